#include "io/mitsuba/references.h"

#include <algorithm>
#include <unordered_map>

namespace metrolux::mitsuba {
namespace {

std::string nameOf(const Element& element) {
    return element.id.empty() ? fmt::format("<{} type=\"{}\">", element.tag, element.type)
                              : fmt::format("\"{}\"", element.id);
}

}  // namespace

void References::addElement(const std::shared_ptr<Element>& element) {
    elements_.push_back(element);
    if (element->id.empty()) return;
    const auto [entry, isNew] = ids_.emplace(element->id, element);
    if (!isNew)
        throw element->error(
            fmt::format("found the id \"{}\" a second time, expected unique ids (first at {})", element->id,
                        entry->second->location.str()));
}

void References::addReference(Element& parent, int order, const std::string& id, const Location& location) {
    references_.push_back({&parent, order, id, location, nullptr});
}

void References::addAlias(const std::string& id, const std::string& as, const Location& location) {
    if (!aliases_.emplace(as, Alias{id, location}).second)
        throw Error("{}: <alias>: found the id \"{}\" a second time, expected unique ids", location.str(),
                    as);
}

std::shared_ptr<Element> References::find(const Reference& reference) const {
    std::string id = reference.id;
    for (size_t step = 0; step <= aliases_.size(); ++step) {
        if (const auto entry = ids_.find(id); entry != ids_.end()) return entry->second;
        const auto alias = aliases_.find(id);
        if (alias == aliases_.end()) break;
        id = alias->second.id;
    }
    std::vector<std::string> known;
    for (const auto& entry : ids_) known.push_back(entry.first);
    const std::string nearest = nearestName(id, known);
    throw Error("{}: <ref id=\"{}\"> in <{} type=\"{}\">: no element has this id{}", reference.location.str(),
                reference.id, reference.parent->tag, reference.parent->type,
                nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest));
}

void References::resolve() {
    for (const auto& [as, alias] : aliases_) {
        if (const auto entry = ids_.find(as); entry != ids_.end())
            throw Error("{}: <alias>: the id \"{}\" is taken by the element at {}", alias.location.str(), as,
                        entry->second->location.str());
        if (!ids_.contains(alias.id) && !aliases_.contains(alias.id))
            throw Error("{}: <alias id=\"{}\">: no element has this id", alias.location.str(), alias.id);
    }
    for (Reference& reference : references_) reference.target = find(reference);
    checkGraph();  // before linking: a cycle of shared pointers would never be freed
    for (const Reference& reference : references_) {
        referenced_.insert(reference.target.get());
        for (auto& entry : reference.parent->named)
            if (entry.second.order == reference.order) entry.second.value = ElementPtr(reference.target);
        for (Property& property : reference.parent->children)
            if (property.order == reference.order) property.value = ElementPtr(reference.target);
    }
}

void References::checkGraph() const {
    std::unordered_map<const Element*, size_t> index;
    for (size_t i = 0; i < elements_.size(); ++i) index[elements_[i].get()] = i;
    std::vector<std::vector<size_t>> below(elements_.size());
    std::vector<size_t> parents(elements_.size(), 0);
    const auto connect = [&](const Element& from, const Element* to) {
        const auto source = index.find(&from), target = index.find(to);
        if (source == index.end() || target == index.end()) return;
        below[source->second].push_back(target->second);
        ++parents[target->second];
    };
    for (const auto& element : elements_) {
        const auto connectTo = [&](const Property& property) {
            if (const ElementPtr* child = std::get_if<ElementPtr>(&property.value); child && *child)
                connect(*element, child->get());
        };
        for (const auto& entry : element->named) connectTo(entry.second);
        for (const Property& property : element->children) connectTo(property);
    }
    for (const Reference& reference : references_) connect(*reference.parent, reference.target.get());

    // Kahn's topological order; levels are longest paths.
    std::vector<int> level(elements_.size(), 0);
    std::vector<size_t> ready;
    for (size_t i = 0; i < elements_.size(); ++i)
        if (parents[i] == 0) ready.push_back(i);
    size_t done = 0;
    for (; done < ready.size(); ++done) {
        const size_t i = ready[done];
        if (level[i] > kMaxDepth)
            throw elements_[i]->error(
                fmt::format("elements are nested more than {} levels deep, references included", kMaxDepth));
        for (const size_t child : below[i]) {
            level[child] = std::max(level[child], level[i] + 1);
            if (--parents[child] == 0) ready.push_back(child);
        }
    }
    if (done == elements_.size()) return;

    // Every element that is left has a parent that is left: walking upward from one finds a cycle.
    std::vector<size_t> above(elements_.size(), elements_.size());
    for (size_t i = 0; i < elements_.size(); ++i)
        if (parents[i] > 0)
            for (const size_t child : below[i])
                if (parents[child] > 0) above[child] = i;
    size_t at = 0;
    while (parents[at] == 0 || above[at] == elements_.size()) ++at;
    for (size_t step = 0; step < elements_.size(); ++step) at = above[at];
    std::string cycle = nameOf(*elements_[at]);
    size_t shown = 0;
    for (size_t i = above[at]; i != at && shown < 8; i = above[i], ++shown)
        cycle = nameOf(*elements_[i]) + " -> " + cycle;
    throw elements_[at]->error(
        fmt::format("references form a cycle: {} -> {}", nameOf(*elements_[at]), cycle));
}

}  // namespace metrolux::mitsuba
