#include "io/pbrt/scene.h"

#include "base/suggest.h"
#include "io/mitsuba/maker.h"
#include "io/pbrt/lights.h"
#include "io/pbrt/maps.h"
#include "io/pbrt/materials.h"
#include "io/pbrt/media.h"
#include "io/pbrt/shapes.h"
#include "io/pbrt/view.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace metrolux::core::pbrt {
namespace {

using mitsuba::Element;
using mitsuba::ElementPtr;
using mitsuba::Maker;
using mitsuba::ParsedScene;
using mitsuba::settledMap;
using Kind = Token::Kind;

constexpr size_t kMostNested = 4096;
/// Allowance for what a shape, an instance or a light takes as an object.
constexpr uint64_t kObjectBytes = 1024;

/// What AttributeBegin keeps and AttributeEnd brings back.
struct State {
    CurrentMap place;
    bool reversed = false;
    Materials::Handle material;
    std::optional<AreaLight> light;
    std::map<std::string, std::vector<Parameter>> defaults;  ///< of Attribute, by target
    ColorSpace space;
    MediumInterface media;
};

class SceneReader {
  public:
    SceneReader(const std::filesystem::path& file, bool lenient, MemoryBudget& memory)
        : reading_{lenient, memory},
          lexer_(file, memory),
          textures_(reading_),
          materials_(reading_, textures_),
          media_(reading_),
          scene_("scene", "", {file.string(), 0, ""}) {
        reading_.folder = file.parent_path();
        state_.material = std::make_shared<Materials::Definition>(
            Materials::Definition{"diffuse", Parameters("Material \"diffuse\"", {file.string(), 0, ""}), {}});
    }

    ParsedScene run() {
        for (Token token = lexer_.next(); token.kind != Kind::End; token = lexer_.next()) {
            if (token.kind != Kind::Word)
                throw token.error(fmt::format("found \"{}\", expected a directive", token.shown()));
            directive(token);
        }
        if (!open_.empty())
            throw Error("{}: found the end of the file, expected {}", open_.back().begin.where().str(),
                        open_.back().end);
        if (!inWorld_) beginWorld();
        ParsedScene result;
        result.root = scene_.done();
        result.searchPaths = {reading_.folder};
        result.files = lexer_.files();
        result.files.insert(reading_.files.begin(), reading_.files.end());
        result.warnings = std::move(reading_.warnings);
        return result;
    }

  private:
    using Action = void (SceneReader::*)(const Token&);
    struct Directive {
        const char* name;
        Action action;
    };
    static const std::vector<Directive>& directives();

    void directive(const Token& token) {
        if (maps_.read(token, lexer_, reading_, state_.place)) return;
        std::vector<std::string> names = Maps::directives();
        for (const Directive& d : directives()) {
            if (token.text == d.name) return (this->*d.action)(token);
            names.emplace_back(d.name);
        }
        const std::string nearest = nearestName(token.shown(), names);
        throw token.error(fmt::format("found the directive \"{}\"{}, expected one of pbrt's", token.shown(),
                                      nearest.empty() ? "" : fmt::format(" (did you mean {}?)", nearest)));
    }

    // What directives are made of.

    Parameters parameters(const Token& token, const std::string& owner, const char* defaults = nullptr) {
        Parameters result(owner, token.where());
        result.read(lexer_, reading_.memory);
        if (defaults)
            if (const auto found = state_.defaults.find(defaults); found != state_.defaults.end())
                result.addDefaults(found->second);
        return result;
    }
    TypedDirective typed(const Token& token, const char* defaults = nullptr) {
        std::string type = lexer_.text(token);
        Parameters p = parameters(token, fmt::format("{} \"{}\"", token.shown(), type), defaults);
        return {std::move(type), std::move(p), true};
    }
    void requireWorld(const Token& token) {
        if (!inWorld_) throw token.error(fmt::format("found {} before WorldBegin", token.shown()));
    }

    void reverseOrientation(const Token&) { state_.reversed = !state_.reversed; }

    // Blocks.

    struct Block {
        Token begin;
        const char* end;
        State kept;
    };
    void openBlock(const Token& t, const char* end) {
        if (open_.size() >= kMostNested)
            throw t.error(fmt::format("blocks are nested more than {} levels deep", kMostNested));
        reading_.memory.take(sizeof(Block), "the scene");
        open_.push_back({t, end, state_});
    }
    State closeBlock(const Token& t) {
        if (open_.empty() || t.text != open_.back().end)
            throw t.error(fmt::format("found {}{}", t.shown(),
                                      open_.empty()
                                          ? " without its beginning"
                                          : fmt::format(", expected {} first (of {})", open_.back().end,
                                                        open_.back().begin.where().str())));
        State kept = std::move(open_.back().kept);
        open_.pop_back();
        return kept;
    }
    void attributeBegin(const Token& t) { openBlock(t, "AttributeEnd"); }
    void attributeEnd(const Token& t) { state_ = closeBlock(t); }
    void transformBegin(const Token& t) { openBlock(t, "TransformEnd"); }
    void transformEnd(const Token& t) { state_.place = closeBlock(t).place; }
    void objectBegin(const Token& t) {
        requireWorld(t);
        if (group_) throw t.error("found ObjectBegin within an object");
        openBlock(t, "ObjectEnd");
        const std::string name = lexer_.text(t);
        group_ = &groups_[name];
        *group_ = {Maker("shape", "shapegroup", t.where()), 0};
    }
    void objectEnd(const Token& t) {
        state_ = closeBlock(t);
        group_ = nullptr;
    }
    void objectInstance(const Token& t) {
        requireWorld(t);
        const std::string name = lexer_.text(t);
        if (group_) throw t.error("found ObjectInstance within an object");
        const auto found = groups_.find(name);
        if (found == groups_.end()) throw t.error(fmt::format("found no object \"{}\" before this", name));
        if (found->second.shapes == 0) return;
        reading_.memory.take(kObjectBytes, "an instance");
        scene_.containing(Maker("shape", "instance", t.where())
                              .with("to_world", settledMap(state_.place.map))
                              .containing(found->second.made.done())
                              .done());
    }
    void attribute(const Token& t) {
        const std::string target = lexer_.text(t);
        Parameters p = parameters(t, "Attribute");
        std::vector<Parameter>& all = state_.defaults[target];
        for (const Parameter& parameter : p.all()) {
            std::erase_if(all, [&](const Parameter& old) { return old.name == parameter.name; });
            all.push_back(parameter);
        }
    }
    void includeFile(const Token& t) {
        const std::string name = lexer_.text(t);
        lexer_.include(reading_.find(name, t.where()));
    }

    // Before WorldBegin.

    void camera(const Token& t) {
        view_.camera = typed(t);
        view_.cameraToWorld = t.located([&] { return state_.place.map.inverse(); });
        cameraMedia_ = state_.media;  // which may be made after it
        maps_.name("camera", view_.cameraToWorld);
    }
    void film(const Token& t) { view_.film = typed(t); }
    void pixelFilter(const Token& t) { view_.filter = typed(t); }
    void integrator(const Token& t) { view_.integrator = typed(t); }
    void withoutEffect(const Token& t) { typed(t); }
    void colorSpace(const Token& t) {
        const std::string name = lexer_.text(t);
        state_.space = t.located([&] { return ColorSpace(name); });
    }
    void option(const Token& t) { parameters(t, "Option"); }
    void worldBegin(const Token&) {
        beginWorld();
        state_.place.map = {};
        maps_.name("world", {});
    }
    void worldEnd(const Token&) {}
    void beginWorld() {
        if (std::exchange(inWorld_, true)) return;
        const auto given = [this](TypedDirective& d, const char* owner) {
            if (!d.isGiven) d.parameters = Parameters(owner, scene_.done()->location);
        };
        given(view_.camera, "Camera");
        given(view_.film, "Film");
        given(view_.filter, "PixelFilter");
        given(view_.integrator, "Integrator");
        exposure_ = view_.exposure();
        scene_.containing(view_.integratorElement(reading_));
        if (view_.camera.isGiven) scene_.containing(placedIn(view_.sensor(reading_), exterior(cameraMedia_)));
    }

    // In the world.

    void material(const Token& t) {
        TypedDirective d = typed(t, "material");
        state_.material = define(std::move(d.type), std::move(d.parameters));
    }
    Materials::Handle define(std::string type, Parameters p) const {
        if (type.empty() || type == "none") type = "interface";
        return std::make_shared<Materials::Definition>(
            Materials::Definition{std::move(type), std::move(p), state_.space});
    }
    void makeNamedMaterial(const Token& t) {
        const std::string name = lexer_.text(t);
        Parameters p = parameters(t, fmt::format("MakeNamedMaterial \"{}\"", name), "material");
        const std::string type = p.requiredString("type");
        materials_.name(name, define(type, std::move(p)));
    }
    void namedMaterial(const Token& t) {
        const std::string name = lexer_.text(t);
        state_.material = materials_.find(name, Parameters("NamedMaterial", t.where()));
    }
    void texture(const Token& t) {
        const std::string name = lexer_.text(t), type = lexer_.text(t), kind = lexer_.text(t);
        textures_.define(name, type, kind, parameters(t, fmt::format("Texture \"{}\"", name), "texture"),
                         state_.space, settledMap(state_.place.map));
    }
    void makeNamedMedium(const Token& t) {
        const std::string name = lexer_.text(t);
        reading_.memory.take(kObjectBytes, "a medium");
        media_.define(name, parameters(t, fmt::format("MakeNamedMedium \"{}\"", name), "medium"),
                      settledMap(state_.place.map), state_.space);
    }
    void mediumInterface(const Token& t) {
        state_.media.interior = state_.media.exterior = lexer_.text(t);
        if (lexer_.peek().kind == Kind::String) state_.media.exterior = lexer_.text(t);
        state_.media.where = t.where();
    }
    ElementPtr exterior(const MediumInterface& media) const {
        return media_.find(media.exterior, media.where);
    }
    void lightSource(const Token& t) {
        requireWorld(t);
        const TypedDirective d = typed(t, "light");
        reading_.memory.take(kObjectBytes, "a light");
        scene_.containing(
            placedIn(makeLight(d.type, d.parameters, state_.place.map, state_.space, exposure_, reading_),
                     exterior(state_.media)));
    }
    void areaLightSource(const Token& t) {
        requireWorld(t);
        const TypedDirective d = typed(t, "light");
        state_.light = readAreaLight(d.type, d.parameters, state_.space, exposure_, textures_, reading_);
    }

    void shape(const Token& t) {
        requireWorld(t);
        const TypedDirective d = typed(t, "shape");
        std::optional<AreaLight> light = state_.light;
        if (light && group_) {
            reading_.warn(d.parameters.error("shapes of objects do not emit, as in pbrt"));
            light.reset();
        }
        const bool isMade = state_.material->made != nullptr;
        ElementPtr bsdf = materials_.bsdf(state_.material);
        if (!isMade) reading_.memory.take(kObjectBytes, "a material");
        bsdf = masked(d.parameters, std::move(bsdf));
        const ShapeOptions options{state_.reversed, light && light->bothSides,
                                   isTextured(*bsdf) || (light && !light->radiance.isConstant()),
                                   light && light->power > 0};
        const Transform map = settledMap(state_.place.map);
        bool isBack = false;  // of what emits to both sides
        for (ShapePart& part : makeShape(d.type, d.parameters, map, options, reading_)) {
            reading_.memory.take(kObjectBytes, "a shape");
            addMedia(part, isBack);
            isBack = options.withBack;
            part.made.containing(bsdf);
            if (light) part.made.containing(light->emitter(part.area, part.triangles, reading_.memory));
            if (group_) {
                group_->made.containing(part.made.done());
                ++group_->shapes;
            } else {
                scene_.containing(part.made.done());
            }
        }
        d.parameters.checkAllUsed(reading_);
    }
    /// A surface with the same on both sides is no boundary, as in pbrt.
    void addMedia(ShapePart& part, bool isBack) const {
        if (state_.media.interior == state_.media.exterior) return;
        const ElementPtr inside = media_.find(state_.media.interior, state_.media.where),
                         outside = exterior(state_.media);
        // A back is turned around, and its front has let nothing of the exterior in.
        if (inside) part.made.with(isBack ? "exterior" : "interior", inside);
        if (isBack && inside) part.made.with("interior", inside);
        if (outside && !isBack) part.made.with("exterior", outside);
    }
    /// Whether it shows how uv lie on its surface.
    static bool isTextured(const Element& element) {
        const mitsuba::Property *u = element.find("alpha_u"), *v = element.find("alpha_v");
        const double* const alpha = u && v ? std::get_if<double>(&u->value) : nullptr;
        if (alpha && std::get_if<double>(&v->value) && *alpha != std::get<double>(v->value)) return true;
        const auto isIt = [](const mitsuba::Property& property) {
            const ElementPtr* child = std::get_if<ElementPtr>(&property.value);
            return child && *child && ((*child)->tag == "texture" || isTextured(**child));
        };
        return std::any_of(element.children.begin(), element.children.end(), isIt) ||
               std::any_of(element.named.begin(), element.named.end(),
                           [&](const auto& entry) { return isIt(entry.second); });
    }
    ElementPtr masked(const Parameters& p, ElementPtr bsdf) {
        if (p.has("shadowalpha"))
            reading_.warn(p.error("\"shadowalpha\" has no effect: shadows are those of \"alpha\""));
        const Texture alpha = textures_.number(p, "alpha", 1);
        if (alpha.isConstant() && alpha.constant().x >= 1) return bsdf;
        Maker result("bsdf", "mask", p.where());
        alpha.addTo(result, "opacity", true);
        return result.containing(std::move(bsdf)).done();
    }

    struct Group {
        Maker made{"shape", "shapegroup", {}};
        size_t shapes = 0;
    };

    Reading reading_;
    Lexer lexer_;
    Textures textures_;
    Materials materials_;
    Media media_;
    MediumInterface cameraMedia_;
    Maker scene_;
    State state_;
    std::vector<Block> open_;
    View view_;
    double exposure_ = 1;
    bool inWorld_ = false;
    Maps maps_;
    std::map<std::string, Group> groups_;
    Group* group_ = nullptr;
};

const std::vector<SceneReader::Directive>& SceneReader::directives() {
    using S = SceneReader;
    static const std::vector<Directive> all = {
        {"Accelerator", &S::withoutEffect},
        {"AreaLightSource", &S::areaLightSource},
        {"Attribute", &S::attribute},
        {"AttributeBegin", &S::attributeBegin},
        {"AttributeEnd", &S::attributeEnd},
        {"Camera", &S::camera},
        {"ColorSpace", &S::colorSpace},
        {"Film", &S::film},
        {"Import", &S::includeFile},
        {"Include", &S::includeFile},
        {"Integrator", &S::integrator},
        {"LightSource", &S::lightSource},
        {"MakeNamedMaterial", &S::makeNamedMaterial},
        {"MakeNamedMedium", &S::makeNamedMedium},
        {"Material", &S::material},
        {"MediumInterface", &S::mediumInterface},
        {"NamedMaterial", &S::namedMaterial},
        {"ObjectBegin", &S::objectBegin},
        {"ObjectEnd", &S::objectEnd},
        {"ObjectInstance", &S::objectInstance},
        {"Option", &S::option},
        {"PixelFilter", &S::pixelFilter},
        {"ReverseOrientation", &S::reverseOrientation},
        {"Sampler", &S::withoutEffect},
        {"Shape", &S::shape},
        {"Texture", &S::texture},
        {"TransformBegin", &S::transformBegin},
        {"TransformEnd", &S::transformEnd},
        {"WorldBegin", &S::worldBegin},
        {"WorldEnd", &S::worldEnd},
    };
    return all;
}

}  // namespace

bool isPbrt(const std::filesystem::path& file) {
    std::string extension = (file.extension() == ".gz" ? file.stem() : file).extension().string();
    for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return extension == ".pbrt";
}

ParsedScene parsePbrt(const std::filesystem::path& file, bool lenient, MemoryBudget& memory) {
    return SceneReader(file, lenient, memory).run();
}

}  // namespace metrolux::core::pbrt
