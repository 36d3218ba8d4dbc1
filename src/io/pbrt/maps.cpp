#include "io/pbrt/maps.h"

namespace metrolux::core::pbrt {
namespace {

/// World to camera, which has x to the right.
Transform lookAt(const Vec3d& eye, const Vec3d& target, const Vec3d& up, const Token& where) {
    const Vec3d z = (target - eye).normalized(), x = up.normalized().cross(z).normalized(), y = z.cross(x);
    if (!(x.length() > 0.5) || !(z.length() > 0.5))
        throw where.error("LookAt: found an eye, a target and an up vector on one line, expected a plane");
    return Transform::fromRows({{x.x, x.y, x.z, -x.dot(eye)},
                                {y.x, y.y, y.z, -y.dot(eye)},
                                {z.x, z.y, z.z, -z.dot(eye)},
                                {0, 0, 0, 1}});
}

/// Column by column.
Transform matrix(const Token& word, Lexer& lexer) {
    const auto v = lexer.numbers<16>(word);
    double rows[4][4];
    for (size_t i = 0; i < 16; ++i) rows[i % 4][i / 4] = v[i];
    return Transform::fromRows(rows);
}

using Make = Transform (*)(const Token&, Lexer&);
struct Directive {
    const char* name;
    Make make;
    bool replaces;  ///< the map so far, in place of being multiplied from the right
};
constexpr Directive kDirectives[] = {
    {"Identity", [](const Token&, Lexer&) { return Transform(); }, true},
    {"Translate",
     [](const Token& word, Lexer& lexer) {
         const auto v = lexer.numbers<3>(word);
         return Transform::translate({v[0], v[1], v[2]});
     },
     false},
    {"Scale",
     [](const Token& word, Lexer& lexer) {
         const auto v = lexer.numbers<3>(word);
         return Transform::fromRows({{v[0], 0, 0, 0}, {0, v[1], 0, 0}, {0, 0, v[2], 0}, {0, 0, 0, 1}});
     },
     false},
    {"Rotate",
     [](const Token& word, Lexer& lexer) {
         const auto v = lexer.numbers<4>(word);
         return Transform::rotate(Vec3f(Vec3d(v[1], v[2], v[3])), v[0]);
     },
     false},
    {"LookAt",
     [](const Token& word, Lexer& lexer) {
         const auto v = lexer.numbers<9>(word);
         return lookAt({v[0], v[1], v[2]}, {v[3], v[4], v[5]}, {v[6], v[7], v[8]}, word);
     },
     false},
    {"Transform", matrix, true},
    {"ConcatTransform", matrix, false},
};

}  // namespace

std::vector<std::string> Maps::directives() {
    std::vector<std::string> names = {"CoordinateSystem", "CoordSysTransform", "ActiveTransform",
                                      "TransformTimes"};
    for (const Directive& directive : kDirectives) names.emplace_back(directive.name);
    return names;
}

bool Maps::read(const Token& word, Lexer& lexer, Reading& reading, CurrentMap& current) {
    for (const Directive& directive : kDirectives) {
        if (word.text != directive.name) continue;
        const Transform map = word.located([&] { return directive.make(word, lexer); });
        if (current.moves) current.map = directive.replaces ? map : current.map * map;
        return true;
    }
    if (word.text == "CoordinateSystem") {
        systems_[lexer.text(word)] = current.map;
    } else if (word.text == "CoordSysTransform") {
        const std::string name = lexer.text(word);
        const auto found = systems_.find(name);
        if (found == systems_.end())
            throw word.error(
                fmt::format("found the coordinate system \"{}\", which has not been named before", name));
        if (current.moves) current.map = found->second;
    } else if (word.text == "ActiveTransform") {
        const Token which = lexer.next();
        if (which.text != "StartTime" && which.text != "EndTime" && which.text != "All")
            throw which.error(fmt::format("found {}, expected StartTime, EndTime or All", which.shown()));
        current.moves = which.text != "EndTime";
        if (!current.moves) reading.warn(word.error("scenes do not move: maps of EndTime are left out"));
    } else if (word.text == "TransformTimes") {
        lexer.numbers<2>(word);
    } else {
        return false;
    }
    return true;
}

}  // namespace metrolux::core::pbrt
