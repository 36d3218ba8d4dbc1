#include "io/mitsuba/attributes.h"
#include "io/mitsuba/values.h"

namespace metrolux::core::mitsuba {
namespace {

/// x, y, z, each with a default, or all of them as `value`.
Vec3d components(const Attributes& attributes, double fallback) {
    if (attributes.has("value")) {
        if (attributes.has("x") || attributes.has("y") || attributes.has("z"))
            throw Error("found value together with x, y or z, expected one form");
        return parseVec3(attributes["value"]);
    }
    Vec3d result(fallback);
    if (attributes.has("x")) result.x = parseWithinFloat(attributes["x"]);
    if (attributes.has("y")) result.y = parseWithinFloat(attributes["y"]);
    if (attributes.has("z")) result.z = parseWithinFloat(attributes["z"]);
    return result;
}

Vec3d point(const std::string& name, const std::string& text) {
    if (splitList(text).size() != 3) throw Error("{}: found \"{}\", expected three numbers", name, text);
    return parseVec3(text);
}

Transform matrix(const std::string& text) {
    const std::vector<double> values = parseNumberList(text);
    if (values.size() != 9 && values.size() != 16)
        throw Error("found {} numbers, expected 9 or 16", values.size());
    const size_t size = values.size() == 16 ? 4 : 3;
    double rows[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
    for (size_t i = 0; i < size; ++i)
        for (size_t j = 0; j < size; ++j) rows[i][j] = values[i * size + j];
    return Transform::fromRows(rows);
}

/// In 0.2 and 0.3 each of the points had three attributes.
Transform lookAtOfNumbers(const Attributes& a) {
    const auto vector = [&](const char* x, const char* y, const char* z) {
        return Vec3d(parseWithinFloat(a[x]), parseWithinFloat(a[y]), parseWithinFloat(a[z]));
    };
    return Transform::lookAt(vector("ox", "oy", "oz"), vector("tx", "ty", "tz"),
                             Vec3f(vector("ux", "uy", "uz")));
}

Transform lookAt(const Attributes& attributes) {
    const Vec3d origin = point("origin", attributes["origin"]),
                target = point("target", attributes["target"]);
    Vec3f up(0.0f);
    if (attributes.has("up")) up = Vec3f(point("up", attributes["up"]));
    if (up == Vec3f(0.0f)) {  // Mitsuba then picks any
        const Vec3d direction = target - origin;
        up = std::abs(direction.y) < 0.9 * direction.length() ? Vec3f(0, 1, 0) : Vec3f(1, 0, 0);
    }
    return Transform::lookAt(origin, target, up);
}

Transform operation(const Source& source, pugi::xml_node node, Parameters& parameters, bool legacy) {
    const std::string tag = node.name();
    if (tag == "translate")
        return Transform::translate(components({source, node, parameters, {}, {"x", "y", "z", "value"}}, 0));
    if (tag == "scale")
        return Transform::scale(
            Vec3f(components({source, node, parameters, {}, {"x", "y", "z", "value"}}, 1)));
    if (tag == "rotate") {
        const Attributes attributes(source, node, parameters, {"angle"}, {"x", "y", "z", "value"});
        return Transform::rotate(Vec3f(components(attributes, 0)), parseNumber(attributes["angle"]));
    }
    if (tag == "matrix") return matrix(Attributes(source, node, parameters, {"value"})["value"]);
    if (legacy && tag == "lookAt" && node.attribute("ox"))
        return lookAtOfNumbers(
            {source, node, parameters, {"ox", "oy", "oz", "tx", "ty", "tz", "ux", "uy", "uz"}});
    if (tag == "lookat" || (legacy && tag == "lookAt"))
        return lookAt({source, node, parameters, {"origin", "target"}, {"up"}});
    const std::string nearest = nearestName(tag, {"translate", "scale", "rotate", "matrix", "lookat"});
    throw Error("unknown inside <transform>{}", nearest.empty()
                                                    ? ", expected translate, scale, rotate, matrix or lookat"
                                                    : fmt::format("; did you mean <{}>?", nearest));
}

}  // namespace

namespace {

/// The numbers of a step have no characters that XML would take otherwise.
std::string stepText(pugi::xml_node node, Parameters& parameters) {
    const std::string tag = node.name();
    std::string result = fmt::format("<{}", tag == "lookAt" ? "lookat" : tag);
    for (const pugi::xml_attribute attribute : node.attributes())
        result += fmt::format(" {}=\"{}\"", attribute.name(), parameters.substitute(attribute.value()));
    return result + "/>";
}

}  // namespace

Transform parseTransform(const Source& source, pugi::xml_node node, Parameters& parameters, bool legacy,
                         std::string* steps) {
    Transform result;
    for (const pugi::xml_node child : node.children()) {
        if (child.type() == pugi::node_pcdata || child.type() == pugi::node_cdata)
            throw nodeError(source, child.parent(), "found text inside, expected transform elements");
        if (child.type() != pugi::node_element) continue;
        if (child.first_child()) throw nodeError(source, child, "expected nothing inside this element");
        Transform next;
        try {
            next = operation(source, child, parameters, legacy);
        } catch (const Error& problem) {
            const std::string message = problem.what();  // errors of attributes say already where they are
            if (message.starts_with(source.file().string())) throw;
            throw nodeError(source, child, message);
        }
        result = next * result;
        if (steps) *steps += stepText(child, parameters);
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j)
                if (!std::isfinite(result.at(i, j)))
                    throw nodeError(source, child, "the product of the transforms is not finite");
    }
    return result;
}

}  // namespace metrolux::core::mitsuba
