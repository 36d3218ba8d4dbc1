#include "io/mitsuba/attributes.h"

#include <algorithm>

namespace metrolux::core::mitsuba {

Error nodeError(const Source& source, pugi::xml_node node, const std::string& message) {
    std::string text = node.name();
    for (const char* name : {"type", "name", "id"}) {
        const std::string value = node.attribute(name).value();
        if (value.empty()) continue;
        text += fmt::format(" {}=\"{}\"", name, value.size() <= 60 ? value : value.substr(0, 57) + "...");
    }
    return Error("{}: <{}>: {}", source.at(node).str(), text, message);
}

Attributes::Attributes(const Source& source, pugi::xml_node node, Parameters& parameters,
                       std::initializer_list<const char*> required,
                       std::initializer_list<const char*> optional) {
    std::vector<std::string> known(required.begin(), required.end());
    known.insert(known.end(), optional.begin(), optional.end());
    for (const pugi::xml_attribute attribute : node.attributes()) {
        const std::string name = attribute.name();
        if (std::find(known.begin(), known.end(), name) == known.end()) {
            const std::string nearest = nearestName(name, known);
            const Error problem =
                nodeError(source, node,
                          fmt::format("found the attribute \"{}\", which does not belong here{}", name,
                                      nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest)));
            if (!parameters.forgiven) throw problem;
            parameters.forgiven->emplace_back(problem.what());
            continue;
        }
        if (has(name.c_str()))
            throw nodeError(source, node, fmt::format("found the attribute \"{}\" twice", name));
        try {
            values_.emplace_back(name, parameters.substitute(attribute.value()));
        } catch (const Error& problem) {
            throw nodeError(source, node, fmt::format("attribute \"{}\": {}", name, problem.what()));
        }
    }
    for (const char* name : required)
        if (!has(name))
            throw nodeError(source, node, fmt::format("has no attribute \"{}\", expected one", name));
}

const std::string* Attributes::find(const char* name) const {
    for (const auto& [key, value] : values_)
        if (key == name) return &value;
    return nullptr;
}

}  // namespace metrolux::core::mitsuba
