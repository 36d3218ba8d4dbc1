#include "io/mitsuba/field_of_view.h"

#include "io/mitsuba/values.h"

namespace metrolux::core::mitsuba {

FieldOfView readFieldOfView(const Element& element) {
    if (element.has("fov") && element.has("focal_length"))
        throw element.error("found \"fov\" and \"focal_length\", expected one of them");
    FieldOfView result;
    if (element.has("fov")) {
        result.degrees = element.number("fov", 0);
        if (!(result.degrees > 0 && result.degrees < 180))
            throw element.error(
                fmt::format("found a \"fov\" of {} degrees, expected one in (0, 180)", result.degrees));
        const std::string axis = element.string("fov_axis", "x");
        const std::vector<std::pair<std::string, FovAxis>> axes = {{"x", FovAxis::X},
                                                                   {"y", FovAxis::Y},
                                                                   {"diagonal", FovAxis::Diagonal},
                                                                   {"smaller", FovAxis::Smaller},
                                                                   {"larger", FovAxis::Larger}};
        for (const auto& [name, value] : axes)
            if (axis == name) {
                result.axis = value;
                return result;
            }
        throw element.error("found fov_axis \"" + axis + "\", expected x, y, diagonal, smaller or larger");
    }
    element.ignore("fov_axis");  // a focal length is always about the diagonal
    std::string length = element.string("focal_length", "50mm");
    if (length.ends_with("mm")) length.resize(length.size() - 2);
    double millimeters = 0;
    try {
        millimeters = parseNumber(length);
    } catch (const Error& problem) {
        throw element.error(std::string("\"focal_length\": ") + problem.what());
    }
    if (!(millimeters > 0)) throw element.error("\"focal_length\" must be positive");
    constexpr double kFilmDiagonal = 43.266615305567875;  // of a 36 mm x 24 mm frame
    result.degrees =
        static_cast<float>(2 * std::atan(kFilmDiagonal / (2 * millimeters)) * (180 / std::numbers::pi));
    result.axis = FovAxis::Diagonal;
    return result;
}

bool isSimilarity(const Transform& transform) {
    constexpr float kTolerance = 2e-3f;
    const Vec3f x = transform.vector({1, 0, 0}), y = transform.vector({0, 1, 0}),
                z = transform.vector({0, 0, 1});
    const float length2 = lengthSquared(z);
    const auto same = [&](float a, float b) { return std::abs(a - b) <= kTolerance * length2; };
    return same(lengthSquared(x), length2) && same(lengthSquared(y), length2) && same(dot(x, y), 0) &&
           same(dot(y, z), 0) && same(dot(z, x), 0);
}

}  // namespace metrolux::core::mitsuba
