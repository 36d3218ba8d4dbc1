#include "io/mitsuba/mesh_attributes.h"

namespace metrolux::core::mitsuba {
namespace {

using Names = std::vector<std::string>;

void collect(const Element& element, Names& names) {
    if (element.tag == "texture" && element.type == "mesh_attribute")
        if (const Property* name = element.find("name"))
            if (const std::string* text = std::get_if<std::string>(&name->value)) names.push_back(*text);
    const auto visit = [&](const Property& property) {
        if (const ElementPtr* child = std::get_if<ElementPtr>(&property.value); child && *child)
            collect(**child, names);
    };
    for (const auto& entry : element.named) visit(entry.second);
    for (const Property& property : element.children) visit(property);
}

std::string attributesOf(const Shape& shape) {
    const auto* mesh = dynamic_cast<const TriangleMesh*>(&shape);
    if (!mesh || mesh->attributes.empty()) return "it has none";
    std::string list;
    for (const TriangleMesh::Attribute& a : mesh->attributes) list += (list.empty() ? "" : ", ") + a.name;
    return "it has: " + list;
}

}  // namespace

void checkAttributes(const Element& element, const Shape& shape, LoadContext& context) {
    const auto [entry, isNew] = context.attributesRead.try_emplace(&element);
    if (isNew) collect(element, entry->second);
    for (const std::string& name : entry->second) {
        if (shape.attributeChannels(name) > 0) continue;
        const std::string message =
            fmt::format("it reads the mesh attribute \"{}\", which the shape ({}) does not have; {}", name,
                        shape.id, attributesOf(shape));
        if (!context.lenient) throw element.error(message);
        context.warn(element, message + " (black stands in)");
    }
}

}  // namespace metrolux::core::mitsuba
