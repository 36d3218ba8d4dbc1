/// Uses the installed library as a program of somebody else does; exits with 0 if all is as promised.

#include <metrolux/metrolux.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace {

int failures = 0;

void check(bool holds, const char* what) {
    if (holds) return;
    std::fprintf(stderr, "not so: %s\n", what);
    ++failures;
}

/// A square of 2x2 units that shines, before a wall of triangles.
metrolux::Object squareAndWall() {
    using metrolux::Color;
    using metrolux::Object;
    using metrolux::Transform;
    metrolux::Mesh wall;
    wall.positions = {-3, -3, 0, 3, -3, 0, 3, 3, 0, -3, 3, 0};
    wall.triangles = {0, 1, 2, 0, 2, 3};
    return Object(
        "scene",
        {{"integrator", Object("path", {{"max_depth", 4}})},
         {"sensor", Object("perspective", {{"to_world", Transform::lookAt({0, 0, 6}, {0, 0, 0}, {0, 1, 0})},
                                           {"fov", 45.0},
                                           {"film", Object("hdrfilm", {{"width", 32}, {"height", 24}})}})},
         {"gray", Object("diffuse", {{"reflectance", Color{0.5, 0.5, 0.5}}})},
         {"wall", Object("mesh", {{"arrays", wall}, {"bsdf", metrolux::Reference{"gray"}}})},
         {"lamp", Object("rectangle",
                         {{"to_world", Transform::translate({0, 0, 2}) * Transform::rotate({0, 1, 0}, 180)},
                          {"emitter", Object("area", {{"radiance", Color{4, 3, 2}}})}})}});
}

bool sameBits(const metrolux::ImageView& a, const metrolux::ImageView& b) {
    return a.size() == b.size() && std::memcmp(a.data, b.data, a.size() * sizeof(float)) == 0;
}

void run(const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    const metrolux::Scene scene = metrolux::Scene::make(squareAndWall());
    check(scene.sizes().primitives == 4, "the wall and the lamp are two triangles each");
    check(scene.warnings().empty(), "a sound scene makes no warnings");

    metrolux::FilmChange half;
    half.resolution = metrolux::Resolution{16, 12};
    const metrolux::Scene small = scene.withFilm(half);
    check(small.sharesGeometryWith(scene), "another resolution leaves the geometry where it is");
    check(small.resolution().width == 16, "it has the resolution that was asked for");

    metrolux::SessionOptions options;
    options.integrator = "vcm";
    options.seed = 7;
    metrolux::Session whole(small, options);
    for (int i = 0; i < 6; ++i) whole.step();
    check(whole.progress().passes == 6, "six steps are six passes");
    const metrolux::ImageView image = whole.image();
    check(image.height == 12 && image.width == 16 && image.channels == 3,
          "an image of 12 rows of 16 RGB pixels");
    double sum = 0;
    for (std::size_t i = 0; i < image.size(); ++i) sum += static_cast<double>(image.data[i]);
    check(std::isfinite(sum) && sum > 0, "light on the wall");

    metrolux::Session part(small, options);
    for (int i = 0; i < 3; ++i) part.step();
    part.save(folder / "part.checkpoint");
    metrolux::Session rest(small, options);
    rest.resume(folder / "part.checkpoint");
    metrolux::Limits limits;
    limits.passes = 6;
    rest.render(limits);
    check(sameBits(rest.image(), image), "a session that goes on from a checkpoint ends with the same bits");

    whole.saveImage(folder / "image.exr");
    check(sameBits(metrolux::readImage(folder / "image.exr").view(), image), "an EXR keeps all bits");
    check(std::string(whole.statistics()).find("\"passes\": 6") != std::string::npos,
          "statistics count the passes");

    options.integrator = "vmc";
    std::string message;
    try {
        metrolux::Session wrong(small, options);
    } catch (const metrolux::Error& error) {
        message = error.what();
    }
    check(message.find("did you mean 'vcm'") != std::string::npos,
          "an unknown name is an Error with the nearest one");
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) return 2;
    try {
        run(argv[1]);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
    std::printf("consumer of Metrolux %s: %d failures\n", metrolux::version(), failures);
    return failures == 0 ? 0 : 1;
}
