/// Scenes of the repository, written as pbrt says them: the same pictures. What pbrt says otherwise is made
/// the same in Mitsuba's scene first: its microfacets are GGX, and below a coat all reflections count.

#include "io/mitsuba/parser.h"
#include "paths.h"
#include "pbrt_support.h"
#include "scattering/ior_table.h"

#include <fstream>
#include <map>
#include <numbers>
#include <sstream>

namespace metrolux::core::test {
namespace {

namespace fs = std::filesystem;
using mitsuba::Element;
using mitsuba::ElementPtr;
using mitsuba::RgbValue;

std::string replaced(std::string text, const std::string& what, const std::string& by) {
    for (size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size()))
        text.replace(at, what.size(), by);
    return text;
}

std::string numbers(std::initializer_list<double> values) {
    std::string text = "[";
    for (const double v : values) text += fmt::format(" {}", v);
    return text + " ]";
}
template <class T>
std::string list(const std::vector<T>& values) {
    std::string text = "[";
    for (const T& v : values)
        if constexpr (std::is_same_v<T, uint32_t>)
            text += fmt::format(" {}", v);
        else
            for (unsigned c = 0; c < T::dimensions(); ++c)
                text += fmt::format(" {}", double(v[static_cast<int>(c)]));
    return text + " ]";
}
std::string matrix(const Transform& m) {
    std::string text = "Transform [";
    for (int i = 0; i < 16; ++i) text += fmt::format(" {}", m.at(i % 4, i / 4));
    return text + " ]\n";
}

/// What the scenes below are made of.
class TwinWriter {
  public:
    std::string write(const Element& scene, const SceneParts& parts) {
        const ElementPtr sensor = scene.childrenOf("sensor").at(0),
                         integrator = scene.childrenOf("integrator").at(0);
        // Ours counts along x, pbrt along the shorter side; images here are 4 : 3.
        const double half = std::tan(double(sensor->number("fov", 0)) * std::numbers::pi / 360) * 0.75;
        text_ = matrix((sensor->transform("to_world") * Transform::scale({-1, 1, 1})).inverse());
        text_ += fmt::format("Camera \"perspective\" \"float fov\" {}\n",
                             std::atan(half) * 360 / std::numbers::pi);
        text_ += fmt::format(
            "Film \"rgb\" \"integer xresolution\" 4 \"integer yresolution\" 3\nIntegrator \"path\" \"integer "
            "maxdepth\" {}\n",
            integrator->integer("max_depth", 0) - 1);
        text_ += "WorldBegin\n";
        const auto shapes = scene.childrenOf("shape");
        for (size_t i = 0; i < shapes.size(); ++i) shape(*shapes[i], *parts.shapes.at(i));
        for (const ElementPtr& light : scene.childrenOf("emitter")) {
            const Vec3d p = light->point("position", Vec3d(0.0));
            text_ += fmt::format("LightSource \"point\" \"point3 from\" {} {}\n", numbers({p.x, p.y, p.z}),
                                 color(*light, "intensity", "I"));
        }
        return text_;
    }

  private:
    std::string color(const Element& e, const std::string& name, const std::string& as) {
        const mitsuba::Property* p = e.find(name);
        if (const auto* rgb = std::get_if<RgbValue>(&p->value))
            return fmt::format("\"rgb {}\" {}", as,
                               numbers({double(rgb->value.x), double(rgb->value.y), double(rgb->value.z)}));
        const Element& texture = *std::get<ElementPtr>(p->value);
        const Transform uv = texture.transform("to_uv");
        const std::string id = fmt::format("t{}", names_.size() + ++textures_);
        if (texture.type == "checkerboard")
            text_ += fmt::format(
                "Texture \"{}\" \"spectrum\" \"checkerboard\" {} {} \"float uscale\" {} \"float vscale\" "
                "{}\n",
                id, color(texture, "color0", "tex1"), color(texture, "color1", "tex2"), 2 * uv.at(0, 0),
                2 * uv.at(1, 1));
        else
            text_ += fmt::format(
                "Texture \"{}\" \"spectrum\" \"imagemap\" \"string filename\" \"{}\" \"float uscale\" {} "
                "\"float vscale\" {} "
                "\"float vdelta\" 1\n",
                id, texture.string("filename", ""), uv.at(0, 0), -uv.at(1, 1));
        return fmt::format("\"texture {}\" \"{}\"", as, id);
    }
    static double ior(const Element& e, const char* name, double fallback) {
        const mitsuba::Property* p = e.find(name);
        if (!p) return fallback;
        if (const auto* text = std::get_if<std::string>(&p->value)) return double(*namedIor(*text));
        return std::get<double>(p->value);
    }
    static std::string eta(const Element& e, double fallback) {
        return fmt::format("\"float eta\" {}",
                           double(float(ior(e, "int_ior", fallback)) / float(ior(e, "ext_ior", 1.000277f))));
    }
    std::string roughness(const Element& e) {
        if (e.has("alpha_u"))
            return fmt::format(
                "\"float uroughness\" {} \"float vroughness\" {} \"bool remaproughness\" false",
                double(e.number("alpha_u", 0)), double(e.number("alpha_v", 0)));
        return e.has("alpha") ? fmt::format("\"float roughness\" {} \"bool remaproughness\" false",
                                            double(e.number("alpha", 0)))
                              : "";
    }
    std::string material(const Element& e) {
        if (e.type == "twosided") return material(*e.childrenOf("bsdf").at(0));
        if (e.type == "diffuse") return "\"diffuse\" " + color(e, "reflectance", "reflectance");
        if (e.type == "dielectric") return "\"dielectric\" " + eta(e, 1.5046);
        if (e.type == "plastic" || e.type == "roughplastic")
            return "\"coateddiffuse\" " + color(e, "diffuse_reflectance", "reflectance") + eta(e, 1.49) +
                   roughness(e);
        if (e.type == "conductor" || e.type == "roughconductor") {
            const auto metal = namedConductor(e.string("material", ""));
            return fmt::format("\"conductor\" \"rgb eta\" {} \"rgb k\" {} {}",
                               numbers({double(metal->eta.x), double(metal->eta.y), double(metal->eta.z)}),
                               numbers({double(metal->k.x), double(metal->k.y), double(metal->k.z)}),
                               roughness(e));
        }
        ADD_FAILURE() << e.type;
        return "";
    }
    const std::string& named(const ElementPtr& bsdf) {
        std::string& name = names_[bsdf.get()];
        if (!name.empty()) return name;
        name = fmt::format("m{}", names_.size());
        const std::string made = material(*bsdf);
        text_ += fmt::format("MakeNamedMaterial \"{}\" \"string type\" {}\n", name, made);
        return name;
    }
    void shape(const Element& e, const Shape& made) {
        const auto bsdfs = e.childrenOf("bsdf"), emitters = e.childrenOf("emitter");
        const std::string material = bsdfs.empty() ? "Material \"diffuse\" \"rgb reflectance\" [0 0 0]\n"
                                                   : fmt::format("NamedMaterial \"{}\"\n", named(bsdfs[0]));
        const std::string light =
            emitters.empty() ? ""
                             : "AreaLightSource \"diffuse\" " + color(*emitters[0], "radiance", "L") + "\n";
        text_ += "AttributeBegin\n" + material + light;
        if (const auto* mesh = dynamic_cast<const TriangleMesh*>(&made)) {
            text_ += "Shape \"trianglemesh\" \"point3 P\" " + list(mesh->positions) +
                     " \"integer indices\" " + list(mesh->indices);
            if (!mesh->normals.empty()) text_ += " \"normal N\" " + list(mesh->normals);
            if (!mesh->uvs.empty()) text_ += " \"point2 uv\" " + list(mesh->uvs);
        } else if (e.type == "sphere") {
            const Vec3d c = e.point("center", Vec3d(0.0));
            text_ += matrix(e.transform("to_world") * Transform::translate(c));
            text_ += fmt::format("Shape \"sphere\" \"float radius\" {}", double(e.number("radius", 1)));
        } else if (e.type == "cylinder") {
            const Vec3d p0 = e.point("p0", Vec3d(0.0)), p1 = e.point("p1", Vec3d(0, 0, 1)),
                        z = (p1 - p0).normalized();
            const Vec3d x = z.cross(std::abs(z.x) < 0.5 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0)).normalized(),
                        y = z.cross(x);
            text_ += matrix(
                e.transform("to_world") *
                Transform::fromRows(
                    {{x.x, y.x, z.x, p0.x}, {x.y, y.y, z.y, p0.y}, {x.z, y.z, z.z, p0.z}, {0, 0, 0, 1}}));
            text_ += fmt::format("Shape \"cylinder\" \"float zmin\" 0 \"float zmax\" {} \"float radius\" {}",
                                 (p1 - p0).length(), double(e.number("radius", 1)));
        } else if (e.type == "disk") {
            text_ += matrix(e.transform("to_world")) + "Shape \"disk\"";
        } else {
            ADD_FAILURE() << e.type;
        }
        text_ += "\nAttributeEnd\n";
    }

    std::string text_;
    std::map<const Element*, std::string> names_;
    size_t textures_ = 0;
};

class PbrtTwins : public testing::TestWithParam<const char*> {};

TEST_P(PbrtTwins, AreTheSamePicture) {
    const TemporaryFolder folder;
    const fs::path original = fs::path(METROLUX_SOURCE_DIR) / "scenes" / GetParam();
    fs::copy(original, folder.path(), fs::copy_options::recursive);
    std::stringstream text;
    text << std::ifstream(original / "scene.xml").rdbuf();
    std::string xml = text.str();
    for (size_t at = 0; (at = xml.find("<bsdf type=\"", at)) != std::string::npos; ++at) {
        const size_t end = xml.find('>', at);
        const std::string tag = xml.substr(at, end - at);
        std::string more;
        if (tag.find("plastic\"") != std::string::npos)
            more += "<boolean name=\"nonlinear\" value=\"true\"/>";
        if (tag.find("\"rough") != std::string::npos &&
            xml.substr(end, xml.find("</bsdf>", end) - end).find("distribution") == std::string::npos)
            more += "<string name=\"distribution\" value=\"ggx\"/>";
        xml.insert(end + 1, more);
    }
    const fs::path file = folder.write("scene.xml", xml);
    LoadOptions options;
    options.setResolution(32, 24);
    const SceneParts parts = loadScene(file, options);
    const fs::path twin =
        folder.write("twin.pbrt", TwinWriter().write(*parseSceneFile(file, {}).root, parts));

    // The same random numbers: pixels differ where rounding sends a path another way.
    const std::vector<float> a = RenderableScene(file, options).render("bdpt", 16, 1),
                             b = RenderableScene(twin, options).render("bdpt", 16, 1);
    size_t different = 0;
    for (size_t i = 0; i < a.size(); ++i) different += std::abs(a[i] - b[i]) > 0.01f * (a[i] + b[i]);
    EXPECT_LT(different, a.size() / 20);
    const auto mean = [](const std::vector<float>& image) {
        double sum = 0;
        for (const float v : image) sum += double(v);
        return sum / double(image.size());
    };
    EXPECT_NEAR(mean(b) / mean(a), 1, 0.01);
    fmt::print("{}: {} of {} values differ, mean {:+.4f} %\n", GetParam(), different, a.size(),
               100 * (mean(b) / mean(a) - 1));
}

INSTANTIATE_TEST_SUITE_P(Scenes, PbrtTwins,
                         testing::Values("door-ajar", "glossy-room", "vitrine", "water-sds"),
                         [](const auto& parameter) { return replaced(parameter.param, "-", "_"); });

}  // namespace
}  // namespace metrolux::core::test
