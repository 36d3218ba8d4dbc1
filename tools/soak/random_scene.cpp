#include "random_scene.h"

#include "base/rng.h"

#include <fmt/format.h>

#include <initializer_list>

namespace metrolux::core::soak {
namespace {

/// Choices that a scene is made of.
class Dice {
  public:
    explicit Dice(uint64_t seed) : rng_(hashKey(seed, 0x50a6)) {}
    bool chance(double p) { return rng_.nextDouble() < p; }
    int below(int n) { return static_cast<int>(rng_.nextDouble() * n); }
    double uniform(double low, double high) { return low + (high - low) * rng_.nextDouble(); }
    template <class T>
    T of(std::initializer_list<T> values) {
        return *(values.begin() + below(static_cast<int>(values.size())));
    }

  private:
    CounterRng rng_;
};

struct Point {
    double x = 0, y = 0, z = 0;
};

std::string attributes(const Point& p) {
    return fmt::format(R"(x="{:.9g}" y="{:.9g}" z="{:.9g}")", p.x, p.y, p.z);
}

std::string number(const char* name, double value) {
    return fmt::format(R"(<float name="{}" value="{:.9g}"/>)", name, value);
}
std::string integer(const char* name, int value) {
    return fmt::format(R"(<integer name="{}" value="{}"/>)", name, value);
}
std::string text(const char* name, const std::string& value) {
    return fmt::format(R"(<string name="{}" value="{}"/>)", name, value);
}
std::string rgb(const char* name, const Point& c) {
    return fmt::format(R"(<rgb name="{}" value="{:.6g} {:.6g} {:.6g}"/>)", name, c.x, c.y, c.z);
}

/// Objects live in a cube of half edge `scale_` around `center_`.
class Generator {
  public:
    explicit Generator(uint64_t seed) : dice_(seed) {
        scale_ = dice_.of({1.0, 1.0, 1.0, 1.0, 100.0, 1e6, 1e-3, 1e-6});
        if (dice_.chance(0.15)) center_ = {1e5 * scale_, -3e4 * scale_, 2e5 * scale_};
    }

    RandomScene make() {
        writeTextures();
        std::string body = integrator() + sensor();
        if (dice_.chance(0.7)) body += room();
        for (int count = dice_.below(7); count > 0; --count) body += object();
        if (dice_.chance(0.2)) body += nestedGlass();
        if (dice_.chance(0.2)) body += instances();
        body += lights();
        result_.xml = "<scene version=\"3.0.0\">\n" + body + "</scene>\n";
        return std::move(result_);
    }

  private:
    Point inside(double share = 1) {
        const double e = share * scale_;
        return {center_.x + dice_.uniform(-e, e), center_.y + dice_.uniform(-e, e),
                center_.z + dice_.uniform(-e, e)};
    }
    Point color() {
        if (dice_.chance(0.1)) return {};
        if (dice_.chance(0.1)) return {1, 1, 1};
        return {dice_.uniform(0, 1), dice_.uniform(0, 1), dice_.uniform(0, 1)};
    }
    Point emission() {
        const double size = dice_.of({1.0, 1.0, 1.0, 10.0, 1e-20, 1e4, 1e12, 1e30});
        return {size * dice_.uniform(0, 1), size, size * dice_.uniform(0, 1)};
    }

    /// PPM files: one pixel, and some.
    void writeTextures() {
        result_.files.emplace_back("one.ppm", std::string("P6\n1 1\n255\n") + "\x80\x40\xff");
        std::string pixels;
        for (int i = 0; i < 3 * 5 * 4; ++i) pixels += static_cast<char>(dice_.below(256));
        result_.files.emplace_back("some.ppm", "P6\n5 4\n255\n" + pixels);
    }
    std::string image() { return text("filename", dice_.of({"one.ppm", "some.ppm"})); }

    std::string integrator() {
        const int depth = dice_.of({-1, -1, 1, 2, 3, 6, 20});
        const int roulette = dice_.of({1, 2, 5, 100});
        return fmt::format(
            R"(<integrator type="path">{}{}<boolean name="hide_emitters" value="{}"/></integrator>)"
            "\n",
            integer("max_depth", depth), integer("rr_depth", roulette), dice_.chance(0.2));
    }

    std::string sensor() {
        const Point eye =
            dice_.chance(0.1) ? Point{center_.x, center_.y - 0.9 * scale_, center_.z} : inside(0.9);
        Point target = inside(0.8);
        if (dice_.chance(0.05)) target = {eye.x, eye.y + scale_, eye.z};  // along `up`: to be refused
        const char* type =
            dice_.of({"perspective", "perspective", "perspective", "thinlens", "orthographic"});
        std::string own;
        if (std::string(type) != "orthographic")
            own = number("fov", dice_.of({45.0, 45.0, 70.0, 0.01, 175.0})) +
                  number("near_clip", scale_ * dice_.of({1e-4, 1e-2, 0.3})) +
                  number("far_clip", scale_ * 1e3);
        if (std::string(type) == "thinlens")
            own += number("aperture_radius", scale_ * dice_.of({0.0, 1e-6, 0.05})) +
                   number("focus_distance", scale_ * dice_.of({0.5, 1.0, 30.0}));
        const double size = std::string(type) == "orthographic" ? scale_ : 1;
        return fmt::format(
            R"(<sensor type="{}">{}<transform name="to_world"><scale value="{:.9g}"/>)"
            R"(<lookat origin="{:.9g} {:.9g} {:.9g}" target="{:.9g} {:.9g} {:.9g}" up="0 1 0"/></transform>)"
            R"(<film type="hdrfilm">{}{}<rfilter type="{}"/></film></sensor>)"
            "\n",
            type, own, size, eye.x, eye.y, eye.z, target.x, target.y, target.z, integer("width", 16),
            integer("height", 12),
            dice_.of({"box", "tent", "gaussian", "mitchell", "catmullrom", "lanczos"}));
    }

    std::string microfacet() {
        const double alpha = dice_.of({0.1, 0.3, 1.0, 1e-3, 1e-5});
        const std::string distribution = text("distribution", dice_.of({"beckmann", "ggx"}));
        if (dice_.chance(0.3)) return distribution + number("alpha_u", alpha) + number("alpha_v", 0.2);
        return distribution + number("alpha", alpha);
    }
    std::string ior() { return number("int_ior", dice_.of({1.5, 1.33, 1.0, 2.4, 1.000001, 0.7})); }
    std::string reflectance(const char* name) {
        if (dice_.chance(0.2))
            return fmt::format(R"(<texture type="bitmap" name="{}">{}</texture>)", name, image());
        if (dice_.chance(0.1)) return fmt::format(R"(<texture type="checkerboard" name="{}"/>)", name);
        return rgb(name, color());
    }

    std::string bsdf(int depth = 0) {
        switch (dice_.below(depth < 2 ? 19 : 12)) {
            default:
                return wrapped("diffuse", reflectance("reflectance"));
            case 3:
                return wrapped("dielectric", ior());
            case 4:
                return wrapped("thindielectric", ior());
            case 5:
                return wrapped("roughdielectric", ior() + microfacet());
            case 6:
                return wrapped("conductor", text("material", dice_.of({"Au", "none", "Cu"})));
            case 7:
                return wrapped("roughconductor", text("material", "Al") + microfacet());
            case 8:
                return wrapped("plastic", ior() + reflectance("diffuse_reflectance"));
            case 9:
                return wrapped("roughplastic", ior() + text("distribution", "ggx") +
                                                   number("alpha", dice_.of({0.1, 0.5, 1e-3})));
            case 10:
                return wrapped("phong", number("exponent", dice_.of({1.0, 30.0, 1e5})));
            case 11:
                return wrapped("ward", number("alpha", dice_.of({0.1, 0.01, 1.0})));
            case 12:
                return wrapped("principled", reflectance("base_color") +
                                                 number("roughness", dice_.uniform(0, 1)) +
                                                 number("metallic", dice_.uniform(0, 1)) +
                                                 number("spec_trans", dice_.of({0.0, 0.5, 1.0})) +
                                                 number("clearcoat", dice_.of({0.0, 1.0})));
            case 13:
                return wrapped("principledthin", reflectance("base_color") +
                                                     number("roughness", dice_.uniform(0, 1)) +
                                                     number("spec_trans", dice_.of({0.0, 0.5, 1.0})) +
                                                     number("diff_trans", dice_.uniform(0, 2)));
            case 14:
                return wrapped("twosided", wrapped("diffuse", reflectance("reflectance")));
            case 15:
                return wrapped("mask", number("opacity", dice_.of({0.0, 0.5, 1.0})) + bsdf(depth + 1));
            case 16:
                return wrapped("blendbsdf", number("weight", dice_.of({0.0, 0.5, 1.0})) + bsdf(depth + 1) +
                                                bsdf(depth + 1));
            case 17:
                return wrapped("bumpmap", number("scale", dice_.of({0.1, 1.0, 100.0})) +
                                              R"(<texture type="bitmap">)" + image() + "</texture>" +
                                              bsdf(depth + 1));
            case 18:
                return wrapped("null", "");
        }
    }
    static std::string wrapped(const char* type, const std::string& content) {
        return fmt::format(R"(<bsdf type="{}">{}</bsdf>)", type, content);
    }

    std::string placed(double size, const Point& at) {
        std::string steps;
        if (dice_.chance(0.5))
            steps += fmt::format(R"(<rotate {} angle="{:.6g}"/>)",
                                 attributes({dice_.uniform(-1, 1), 1, dice_.uniform(-1, 1)}),
                                 dice_.of({0.0, 45.0, 90.0, 123.4}));
        return fmt::format(
            R"(<transform name="to_world"><scale value="{:.9g}"/>{}<translate {}/></transform>)", size, steps,
            attributes(at));
    }
    std::string stretched(double size, const Point& at) {
        const Point s{size * dice_.of({1.0, 1e-4, 30.0}), size * dice_.of({1.0, -1.0}), size};
        return fmt::format(R"(<transform name="to_world"><scale {}/><translate {}/></transform>)",
                           attributes(s), attributes(at));
    }

    std::string shape(const char* type, const std::string& content) {
        return fmt::format("<shape type=\"{}\">{}</shape>\n", type, content);
    }

    std::string room() {
        const double size = scale_;
        const std::string flip = R"(<boolean name="flip_normals" value="true"/>)";
        if (dice_.chance(0.5)) return shape("cube", flip + placed(size, center_) + bsdf());
        return shape(
            "rectangle",
            fmt::format(R"(<transform name="to_world"><rotate x="1" angle="-90"/><scale value="{:.9g}"/>)"
                        R"(<translate {}/></transform>{})",
                        size, attributes({center_.x, center_.y - 0.9 * size, center_.z}), bsdf()));
    }

    std::string object() {
        const double size = scale_ * dice_.of({0.3, 0.3, 0.6, 0.05, 1e-5});
        const Point at = inside(0.7);
        std::string made;
        switch (dice_.below(7)) {
            case 0:
                made = shape("sphere", placed(size, at) + bsdf());
                break;
            case 1:
                made = shape("cube", stretched(size, at) + bsdf());
                break;
            case 2:
                made = shape("cylinder", placed(size, at) + bsdf());
                break;
            case 3:
                made = shape("disk", stretched(size, at) + bsdf());
                break;
            case 4:
                made = shape("rectangle", stretched(size, at) + bsdf());
                break;
            default:
                made = shape("obj", text("filename", mesh()) + placed(size, at) + bsdf());
        }
        if (!dice_.chance(0.15)) return made;
        // A second surface in the same place, of another material.
        const size_t begin = made.find("<bsdf");
        return made + made.substr(0, begin) + bsdf() + "</shape>\n";
    }

    /// A mesh file of one of the kinds that are hard to intersect.
    std::string mesh() {
        const std::string name = fmt::format("mesh{}.obj", result_.files.size());
        const int kind = dice_.below(6), triangles = dice_.of({1, 12, 200});
        std::string file = "# kind " + std::to_string(kind) + "\n";
        for (int i = 0; i < triangles; ++i) file += triangle(kind);
        if (kind == 5 && dice_.chance(0.2)) file = "# no faces: to be refused\nv 0 0 0\n";
        result_.files.emplace_back(name, file);
        return name;
    }
    std::string vertex(double x, double y, double z) {
        return fmt::format("v {:.9g} {:.9g} {:.9g}\n", x, y, z);
    }
    std::string triangle(int kind) {
        const auto random = [&] { return dice_.uniform(-1, 1); };
        const double x = random(), y = random(), z = random();
        std::string corners;
        if (kind == 0)  // a needle
            corners = vertex(x, y, z) + vertex(x + 1, y, z) + vertex(x + 0.5, y + 1e-7, z);
        else if (kind == 1)  // no area: a point, or a line
            corners = vertex(x, y, z) + vertex(x, y, z) + vertex(dice_.chance(0.5) ? x : y, y, z);
        else if (kind == 2)  // all in one place
            corners = vertex(-1, -1, 0) + vertex(1, -1, 0) + vertex(0, 1, 0);
        else if (kind == 3)  // tiny
            corners = vertex(x, y, z) + vertex(x + 1e-6, y, z) + vertex(x, y + 1e-6, z);
        else
            corners =
                vertex(x, y, z) + vertex(random(), random(), random()) + vertex(random(), random(), random());
        // Some with normals that have nothing to do with the surface.
        if (kind == 4) {
            for (int i = 0; i < 3; ++i)
                corners += fmt::format("vn {:.6g} {:.6g} {:.6g}\n", random(),
                                       dice_.chance(0.1) ? 0 : random(), random());
            return corners + "f -3//-3 -2//-2 -1//-1\n";
        }
        return corners + "f -3 -2 -1\n";
    }

    /// Glass within glass, which may hold the camera.
    std::string nestedGlass() {
        std::string result;
        const Point at = inside(0.3);
        double size = scale_ * dice_.of({0.3, 0.9, 3.0});
        for (int layers = 1 + dice_.below(3); layers > 0;
             --layers, size *= dice_.of({0.5, 0.99, 0.999999, 1.0}))
            result += shape("sphere", placed(size, at) + wrapped("dielectric", ior()));
        return result;
    }

    std::string instances() {
        std::string result = shape("shapegroup\" id=\"group",
                                   shape("sphere", bsdf()) + shape("obj", text("filename", mesh()) + bsdf()));
        for (int count = dice_.of({1, 3, 40}); count > 0; --count)
            result += shape("instance", "<ref id=\"group\"/>" + stretched(0.1 * scale_, inside()));
        return result;
    }

    std::string lights() {
        if (dice_.chance(0.05)) return "";
        std::string result;
        if (dice_.chance(0.03))  // thousands
            for (int i = 0; i < 2000; ++i) result += pointLight();
        for (int count = 1 + dice_.below(3); count > 0; --count) result += light();
        if (dice_.chance(0.3)) result += environment();
        return result;
    }

    std::string pointLight() {
        return fmt::format("<emitter type=\"point\"><point name=\"position\" {}/>{}</emitter>\n",
                           attributes(inside()), rgb("intensity", emission()));
    }

    std::string light() {
        const Point at = inside(0.8);
        const double size = scale_ * dice_.of({0.2, 0.02, 1e-5});
        const std::string area =
            fmt::format(R"(<emitter type="area">{}</emitter>)", rgb("radiance", emission()));
        switch (dice_.below(8)) {
            case 0:
                return pointLight();
            case 1:
                return fmt::format("<emitter type=\"spot\">{}{}{}</emitter>\n", placed(1, at),
                                   number("cutoff_angle", dice_.of({20.0, 1e-3, 89.0})),
                                   rgb("intensity", emission()));
            case 2:
                return fmt::format(
                    "<emitter type=\"directional\"><vector name=\"direction\" {}/>{}</emitter>\n",
                    attributes({dice_.uniform(-1, 1), -1, dice_.uniform(-1, 1)}),
                    rgb("irradiance", emission()));
            case 3:
                return fmt::format("<emitter type=\"collimated\">{}{}</emitter>\n", placed(1, at),
                                   rgb("power", emission()));
            case 4:  // inside glass
                return shape("sphere", placed(1.5 * size, at) + wrapped("dielectric", ior())) +
                       shape("sphere", placed(size, at) + area);
            case 5:
                return shape("obj", text("filename", mesh()) + placed(size, at) + area);
            case 6:
                return shape("sphere", placed(size, at) + area + bsdf());
            default:
                return shape("rectangle", placed(size, at) + area);
        }
    }

    std::string environment() {
        switch (dice_.below(3)) {
            case 0:
                return "<emitter type=\"sunsky\"/>\n";
            case 1:
                return fmt::format("<emitter type=\"envmap\">{}</emitter>\n", image());
            default:
                return fmt::format("<emitter type=\"constant\">{}</emitter>\n", rgb("radiance", emission()));
        }
    }

    Dice dice_;
    double scale_ = 1;
    Point center_;
    RandomScene result_;
};

}  // namespace

RandomScene makeRandomScene(uint64_t seed) { return Generator(seed).make(); }

}  // namespace metrolux::core::soak
