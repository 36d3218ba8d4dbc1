#include "io/mitsuba/parser.h"

#include "io/mitsuba/attributes.h"
#include "io/mitsuba/references.h"
#include "io/mitsuba/spectrum_plugins.h"
#include "io/mitsuba/upgrade.h"
#include "io/mitsuba/upgrade_oldest.h"
#include "io/mitsuba/values.h"

#include <algorithm>
#include <charconv>
#include <utility>

namespace metrolux::core::mitsuba {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxIncludeDepth = 15;  // Mitsuba's limit
constexpr int kMaxIncludes = 10000;      // files that include each other twice would be read 2^15 times
constexpr uint64_t kMaxTextBytes = uint64_t{1} << 30;  // of all of them
constexpr uint64_t kElementBytes = 1024;               // allowance for what is kept of one
constexpr size_t kMaxProperties = 4096;                // of one element: names are compared one by one

const std::vector<std::string> kObjectTags = {"integrator", "sensor",  "film",  "rfilter",
                                              "sampler",    "emitter", "shape", "bsdf",
                                              "texture",    "medium",  "phase", "volume"};
const std::vector<std::string> kOtherTags = {
    "scene",  "default", "include", "path",     "alias",     "ref",   "integer", "float",     "boolean",
    "string", "rgb",     "srgb",    "spectrum", "blackbody", "point", "vector",  "transform", "animation"};
const std::vector<std::string> kTransformTags = {"translate", "rotate", "scale", "matrix", "lookat"};

bool contains(const std::vector<std::string>& list, const std::string& name) {
    return std::find(list.begin(), list.end(), name) != list.end();
}

/// A file that is being read.
struct File {
    const Source& source;
    int version, minor;
    bool isLegacy() const { return version < 2; }
    bool isBefore(int minorVersion) const { return version == 0 && minor < minorVersion; }
};

class Parser {
  public:
    Parser(const std::map<std::string, std::string>& defines, bool lenient, MemoryBudget* memory)
        : parameters_(defines), lenient_(lenient), memory_(memory) {}

    ParsedScene run(const fs::path& file) {
        root_ = std::make_shared<Element>();
        root_->tag = "scene";
        sceneFolder_ = file.parent_path();
        readFile(file, *root_, "", 0);
        parameters_.checkDefinesUsed(file.string());
        references_.resolve();
        return {root_, references_.referenced(), searchPaths(), std::move(files_), std::move(warnings_)};
    }

  private:
    std::vector<fs::path> searchPaths() const {
        std::vector<fs::path> result(paths_.rbegin(), paths_.rend());
        result.push_back(sceneFolder_);
        return result;
    }

    /// Reads a file whose objects go into `parent`: those of a <scene>, or its root if that is an object.
    void readFile(const fs::path& path, Element& parent, const std::string& name, int depth) {
        const Source source(path);
        const pugi::xml_node node = source.root();
        textBytes_ += source.bytes();
        if (textBytes_ > kMaxTextBytes)
            throw nodeError(source, node,
                            fmt::format("the scene and what it includes have {}, expected at most {}",
                                        sizeText(textBytes_), sizeText(kMaxTextBytes)));
        const std::string tag = node.name();
        const bool isScene = tag == "scene";
        if (!isScene && (openFiles_.empty() || !contains(kObjectTags, tag)))
            throw nodeError(source, node, "unexpected root element, expected <scene version=\"...\">");
        if (isScene && !name.empty())
            throw nodeError(source, node,
                            fmt::format("included under the name \"{}\", expected a single object", name));
        const auto [version, minor] = versionOf(source, node);
        const File file{source, version, minor};
        // 0.6 does not look at attributes that an element does not have.
        std::vector<std::string>* const outside =
            std::exchange(parameters_.forgiven, file.isLegacy() ? &warnings_ : nullptr);
        files_.insert(path.string());
        openFiles_.push_back(fs::weakly_canonical(path));
        if (!isScene) {
            object(file, node, parent, name, depth + 1);
        } else {
            Attributes(source, node, parameters_, {}, {"version", "id"});
            if (openFiles_.size() == 1) {
                root_->location = source.at(node);
                references_.addElement(root_);
            }
            contents(file, node, parent, depth);
        }
        openFiles_.pop_back();
        parameters_.forgiven = outside;
    }

    /// The version that the file names, major and minor.
    std::pair<int, int> versionOf(const Source& source, pugi::xml_node node) {
        const pugi::xml_attribute attribute = node.attribute("version");
        const std::string version = attribute.value();
        std::string problem;
        int major = 3, minor = 0;
        if (!attribute) {
            problem = "has no attribute \"version\"";
        } else {
            const auto [end, code] = std::from_chars(version.data(), version.data() + version.size(), major);
            const std::string_view rest(end, static_cast<size_t>(version.data() + version.size() - end));
            if (code != std::errc() || (!rest.empty() && rest[0] != '.') ||
                rest.find_first_not_of("0123456789.") != std::string_view::npos || rest.ends_with('.'))
                throw nodeError(
                    source, node,
                    fmt::format("found the version \"{}\", expected a number such as 3.0.0", version));
            if (rest.size() > 1) std::from_chars(rest.data() + 1, rest.data() + rest.size(), minor);
            if (major < 0 || major > 3) problem = fmt::format("found the unknown version \"{}\"", version);
        }
        if (problem.empty()) return {major, minor};
        const Error error =
            nodeError(source, node, problem + ", expected 0.4 to 0.6, 2.x or 3.x (such as \"3.0.0\")");
        if (!lenient_) throw error;
        warnings_.push_back(std::string(error.what()) + "; read as 3.x");
        return {3, 0};
    }

    void contents(const File& file, pugi::xml_node node, Element& element, int depth) {
        if (depth > kMaxDepth)
            throw nodeError(file.source, node,
                            fmt::format("elements are nested more than {} levels deep", kMaxDepth));
        for (const pugi::xml_node child : node.children()) {
            if (child.type() == pugi::node_pcdata || child.type() == pugi::node_cdata)
                throw nodeError(file.source, node,
                                "found text between the tags, expected values in attributes (value=\"...\")");
            if (child.type() == pugi::node_element) item(file, child, element, depth);
        }
    }

    void item(const File& file, pugi::xml_node node, Element& parent, int depth) {
        const std::string tag = file.isBefore(4) ? tagOf04(node.name()) : node.name();
        if (memory_) located(file, node, [&] { memory_->take(kElementBytes, "the element"); });
        if (contains(kObjectTags, tag) || (tag == "spectrum" && node.attribute("type"))) {
            object(file, node, parent, "", depth + 1);
            return;
        }
        if (tag == "subsurface" && file.isLegacy()) {
            object(file, node, parent, "", depth + 1);
            return;
        }
        if (tag == "subsurface") {
            const Error error =
                nodeError(file.source, node, "is of 0.6, expected a medium inside of the shape");
            if (!lenient_) throw error;
            warnings_.push_back(std::string(error.what()) + "; left out");
            return;
        }
        if (tag == "transform") {
            const Attributes attributes(file.source, node, parameters_, {"name"});
            std::string steps;
            const Transform value = parseTransform(file.source, node, parameters_, file.isLegacy(), &steps);
            located(file, node, [&] { addNamed(file, node, parent, attributes["name"], value); });
            parent.named.back().second.text = std::move(steps);
            return;
        }
        if (tag == "animation") {
            animation(file, node, parent);
            return;
        }
        if (node.first_child() && contains(kOtherTags, tag))
            throw nodeError(file.source, node, "expected nothing inside this element");
        if (tag == "include") {
            include(file, node, parent, depth);
        } else if (tag == "default") {
            const Attributes attributes(file.source, node, parameters_, {"name", "value"});
            located(file, node, [&] { parameters_.addDefault(attributes["name"], attributes["value"]); });
        } else if (tag == "path") {
            addPath(file, node, parent);
        } else if (tag == "alias") {
            const Attributes attributes(file.source, node, parameters_, {"id", "as"});
            references_.addAlias(attributes["id"], attributes["as"], file.source.at(node));
        } else if (tag == "ref") {
            reference(file, node, parent);
        } else if (file.isLegacy() && (tag == "mode" || tag == "hide")) {
            warnings_.emplace_back(nodeError(file.source, node, "has no effect and is ignored").what());
        } else if (contains(kOtherTags, tag) && tag != "scene") {
            property(file, node, tag, parent);
        } else {
            unknownTag(file, node, tag);
        }
    }

    [[noreturn]] void unknownTag(const File& file, pugi::xml_node node, const std::string& tag) const {
        if (contains(kTransformTags, tag))
            throw nodeError(file.source, node, "found outside of a <transform>, expected it inside of one");
        std::vector<std::string> known = kObjectTags;
        known.insert(known.end(), kOtherTags.begin() + 1, kOtherTags.end());
        const std::string nearest = nearestName(tag, known);
        throw nodeError(file.source, node,
                        nearest.empty() ? "unknown element"
                                        : fmt::format("unknown element; did you mean <{}>?", nearest));
    }

    void object(const File& file, pugi::xml_node node, Element& parent, const std::string& nameInParent,
                int depth) {
        const bool isRoot = node == file.source.root();
        const Attributes attributes =
            isRoot ? Attributes(file.source, node, parameters_, {"type"}, {"id", "name", "version"})
                   : Attributes(file.source, node, parameters_, {"type"}, {"id", "name"});
        auto element = std::make_shared<Element>();
        element->tag = file.isBefore(4) ? tagOf04(node.name()) : node.name();
        element->type = attributes["type"];
        element->id = attributes.get("id");
        element->location = file.source.at(node);
        element->version = file.version;
        if (element->type.empty())
            throw nodeError(file.source, node, "has an empty type, expected a plugin's name");
        const std::string name = attributes.has("name") ? attributes["name"] : nameInParent;
        contents(file, node, *element, depth);
        if (file.isBefore(5)) upgradeOldest(*element, file.minor);
        if (file.isLegacy()) upgradeElement(*element, warnings_);
        if (element->tag == "spectrum") {
            if (isSpectrumPlugin(element->type) && !name.empty() && element->id.empty()) {
                auto value = spectrumFromPlugin(*element);
                located(file, node, [&] { addNamed(file, node, parent, name, std::move(value)); });
                return;
            }
            element->tag = "texture";  // spectra and textures are one kind of plugin since 2.0
        }
        references_.addElement(element);
        addElement(file, node, parent, name, element);
    }

    /// Scenes do not move: the first of its transforms stands for all.
    void animation(const File& file, pugi::xml_node node, Element& parent) {
        const Attributes attributes(file.source, node, parameters_, {"name"});
        const pugi::xml_node first = node.child("transform");
        if (!first) throw nodeError(file.source, node, "has no <transform>, expected one at least");
        for (const pugi::xml_node child : node.children("transform"))
            Attributes(file.source, child, parameters_, {"time"});
        const Transform value = parseTransform(file.source, first, parameters_, file.isLegacy());
        // A shape of 3.x may move under this name, too.
        const std::string& name = attributes["name"];
        const std::string property = !file.isLegacy() && name == "animation" ? "to_world" : name;
        located(file, node, [&] { addNamed(file, node, parent, property, value); });
        if (first.next_sibling("transform"))
            warnings_.emplace_back(
                nodeError(file.source, node, "scenes do not move: the first of its transforms holds").what());
    }

    void include(const File& file, pugi::xml_node node, Element& parent, int depth) {
        const Attributes attributes(file.source, node, parameters_, {"filename"}, {"name"});
        located(file, node, [&] {
            const fs::path path = findFile(attributes["filename"], file.source.file(), searchPaths());
            const fs::path canonical = fs::weakly_canonical(path);
            if (std::find(openFiles_.begin(), openFiles_.end(), canonical) != openFiles_.end())
                throw Error("{} includes itself (cyclic include)", path.string());
            if (openFiles_.size() > kMaxIncludeDepth)
                throw Error("includes are nested more than {} files deep", kMaxIncludeDepth);
            if (++includes_ > kMaxIncludes) throw Error("more than {} files are included", kMaxIncludes);
            includeFile_ = path;
        });
        readFile(fs::path(includeFile_), parent, attributes.get("name"), depth);
    }

    void addPath(const File& file, pugi::xml_node node, const Element& parent) {
        const Attributes attributes(file.source, node, parameters_, {"value"});
        if (&parent != root_.get()) throw nodeError(file.source, node, "expected directly inside <scene>");
        const fs::path value(attributes["value"]);
        std::vector<fs::path> candidates = {value};
        if (value.is_relative()) {
            candidates = {file.source.file().parent_path() / value};
            for (const fs::path& folder : searchPaths()) candidates.push_back(folder / value);
            candidates.push_back(value);
        }
        for (const fs::path& candidate : candidates) {
            std::error_code code;
            if (!fs::is_directory(candidate, code)) continue;
            paths_.push_back(candidate);
            return;
        }
        throw nodeError(file.source, node,
                        fmt::format("the folder \"{}\" does not exist (looked for {})", value.string(),
                                    candidates.front().string()));
    }

    void reference(const File& file, pugi::xml_node node, Element& parent) {
        const Attributes attributes(file.source, node, parameters_, {"id"}, {"name"});
        const std::string name = attributes.get("name");
        references_.addReference(parent, nextOrder_, name, attributes["id"], file.source.at(node));
        addElement(file, node, parent, name, nullptr);
    }

    void property(const File& file, pugi::xml_node node, const std::string& tag, Element& parent) {
        const Source& source = file.source;
        if (tag == "point" || tag == "vector") {
            const Attributes a(source, node, parameters_, {"name"}, {"x", "y", "z", "value"});
            located(file, node, [&] { addNamed(file, node, parent, a["name"], vector(a)); });
        } else if (tag == "spectrum") {
            const Attributes a(source, node, parameters_, {"name"}, {"value", "filename", "intent"});
            located(file, node, [&] {
                const bool isOld = file.isLegacy() && a.has("value");
                if (const auto channels = isOld ? parseChannels(a["value"]) : std::nullopt)
                    addNamed(file, node, parent, a["name"], RgbValue{*channels});
                else
                    addNamed(file, node, parent, a["name"], spectrum(file, a));
            });
        } else if (tag == "blackbody") {
            const Attributes a(source, node, parameters_, {"name", "temperature"}, {"scale"});
            located(file, node, [&] {
                addNamed(file, node, parent, a["name"], parseBlackbody(a["temperature"], a.get("scale")));
            });
        } else if (tag == "rgb" || tag == "srgb") {
            const Attributes a(source, node, parameters_, {"name", "value"}, {"intent"});
            located(file, node, [&] {
                addNamed(file, node, parent, a["name"],
                         RgbValue{tag == "rgb" ? parseRgb(a["value"]) : parseSrgb(a["value"])});
            });
        } else {
            const Attributes a(source, node, parameters_, {"name", "value"});
            const std::string& text = a["value"];
            located(file, node, [&] {
                if (tag == "float") addNamed(file, node, parent, a["name"], parseNumber(text));
                if (tag == "integer") addNamed(file, node, parent, a["name"], parseInteger(text));
                if (tag == "boolean") addNamed(file, node, parent, a["name"], parseBoolean(text));
                if (tag == "string") addNamed(file, node, parent, a["name"], text);
            });
        }
    }

    static Vec3d vector(const Attributes& attributes) {
        const bool x = attributes.has("x"), y = attributes.has("y"), z = attributes.has("z");
        if (attributes.has("value")) {
            if (x || y || z) throw Error("found value together with x, y or z, expected one form");
            return settled(parseVec3(attributes["value"]));
        }
        if (!x || !y || !z) throw Error("expected the attributes x, y and z, or value");
        return settled({parseWithinFloat(attributes["x"]), parseWithinFloat(attributes["y"]),
                        parseWithinFloat(attributes["z"])});
    }

    SpectrumValue spectrum(const File& file, const Attributes& attributes) const {
        if (attributes.has("value") == attributes.has("filename"))
            throw Error("expected either value or filename");
        if (attributes.has("value")) return parseSpectrum(attributes["value"]);
        const fs::path path = findFile(attributes["filename"], file.source.file(), searchPaths());
        files_.insert(path.string());
        return readSpectrumFile(path);
    }

    /// Runs `action`; its errors get the node's place.
    template <class Action>
    void located(const File& file, pugi::xml_node node, const Action& action) const {
        try {
            action();
        } catch (const Error& problem) {
            throw nodeError(file.source, node, problem.what());
        }
    }

    template <class T>
    void addNamed(const File& file, pugi::xml_node node, Element& parent, const std::string& name, T value) {
        const auto same = [&](const auto& entry) { return entry.first == name; };
        const auto earlier = std::find_if(parent.named.begin(), parent.named.end(), same);
        if (name.empty()) throw Error("found an empty name, expected a property's name");
        if (earlier != parent.named.end()) {
            const std::string problem = fmt::format("found the property \"{}\" a second time", name);
            const std::string first = earlier->second.location.str();
            if (!file.isLegacy()) throw Error("{}, expected it once (first at {})", problem, first);
            const std::string message = fmt::format("{}; the last one holds (first at {})", problem, first);
            warnings_.emplace_back(nodeError(file.source, node, message).what());
            parent.named.erase(earlier);
        }
        if (parent.named.size() >= kMaxProperties)
            throw Error("more than {} properties in one element", kMaxProperties);
        Property entry{std::move(value), file.source.at(node), false, nextOrder_++};
        parent.named.emplace_back(name, std::move(entry));
    }

    void addElement(const File& file, pugi::xml_node node, Element& parent, const std::string& name,
                    ElementPtr element) {
        // In 0.x a child's name need not be unique where children are collected.
        const bool collects = parent.tag == "scene" || parent.type == "shapegroup" || parent.type == "obj";
        const bool repeats = file.isLegacy() && collects && parent.has(name);
        if (!name.empty() && !repeats) {
            located(file, node, [&] { addNamed(file, node, parent, name, std::move(element)); });
        } else {
            parent.children.push_back({std::move(element), file.source.at(node), false, nextOrder_++});
        }
    }

    Parameters parameters_;
    References references_;
    std::shared_ptr<Element> root_;
    fs::path sceneFolder_;
    std::vector<fs::path> paths_;      // <path>s
    std::vector<fs::path> openFiles_;  // includes that are being read, from the scene on
    fs::path includeFile_;
    mutable std::set<std::string> files_;  // what was read is no part of what is parsed
    int includes_ = 0;
    uint64_t textBytes_ = 0;
    int nextOrder_ = 0;
    bool lenient_;
    MemoryBudget* memory_;
    std::vector<std::string> warnings_;
};

}  // namespace

ParsedScene parseScene(const fs::path& file, const std::map<std::string, std::string>& defines, bool lenient,
                       MemoryBudget* memory) {
    return Parser(defines, lenient, memory).run(file);
}

}  // namespace metrolux::core::mitsuba
