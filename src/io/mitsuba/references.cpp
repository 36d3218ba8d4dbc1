#include "io/mitsuba/references.h"

#include <algorithm>
#include <unordered_map>

namespace metrolux::core::mitsuba {
namespace {

std::string nameOf(const Element& element) {
    return element.id.empty() ? fmt::format("<{} type=\"{}\">", element.tag, element.type)
                              : fmt::format("\"{}\"", element.id);
}

/// Where a reference's target goes. Children are in ascending order: there may be a million of them.
/// Null for a property that the upgrade of a 0.x scene has dropped.
Property* findPlace(int order, bool named, Element& parent) {
    if (named) {
        for (auto& entry : parent.named)
            if (entry.second.order == order) return &entry.second;
        return nullptr;
    }
    const auto child = std::lower_bound(parent.children.begin(), parent.children.end(), order,
                                        [](const Property& p, int o) { return p.order < o; });
    return child != parent.children.end() && child->order == order ? &*child : nullptr;
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

void References::addReference(Element& parent, int order, const std::string& name, const std::string& id,
                              const Location& location) {
    references_.push_back({&parent, order, !name.empty(), id, location, nullptr});
}

void References::addAlias(const std::string& id, const std::string& as, const Location& location) {
    if (!aliases_.emplace(as, Alias{id, location}).second)
        throw Error("{}: <alias>: found the id \"{}\" a second time, expected unique ids", location.str(),
                    as);
}

std::shared_ptr<Element> References::find(const Reference& reference) const {
    std::string id = reference.id;
    for (int step = 0; step <= kMaxDepth; ++step) {
        if (const auto entry = ids_.find(id); entry != ids_.end()) return entry->second;
        const auto alias = aliases_.find(id);
        if (alias == aliases_.end()) break;
        id = alias->second.id;
        if (step == kMaxDepth)
            throw Error("{}: <ref id=\"{}\"> in <{} type=\"{}\">: it leads through more than {} aliases",
                        reference.location.str(), reference.id, reference.parent->tag, reference.parent->type,
                        kMaxDepth);
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
        if (Property* place = findPlace(reference.order, reference.named, *reference.parent))
            place->value = ElementPtr(reference.target);
    }
}

References::Graph References::graph() const {
    std::unordered_map<const Element*, size_t> index;
    for (size_t i = 0; i < elements_.size(); ++i) index[elements_[i].get()] = i;
    Graph below(elements_.size());
    const auto connect = [&](const Element& from, const Element* to) {
        const auto source = index.find(&from), target = index.find(to);
        if (source == index.end() || target == index.end()) return;
        below[source->second].push_back(target->second);
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
    return below;
}

void References::checkParts(const Graph& below, const std::vector<size_t>& sorted) const {
    std::vector<uint64_t> parts(elements_.size(), 1);
    for (auto i = sorted.rbegin(); i != sorted.rend(); ++i) {
        const Element& element = *elements_[*i];
        if (element.tag != "bsdf" && element.tag != "texture" && element.tag != "phase") continue;
        for (const size_t child : below[*i]) parts[*i] += parts[child];
        if (parts[*i] > kMaxParts)
            throw element.error(
                fmt::format("found more than {} parts, references included, expected fewer", kMaxParts));
    }
}

void References::checkGraph() const {
    const Graph below = graph();
    std::vector<size_t> parents(elements_.size(), 0);
    for (const auto& children : below)
        for (const size_t child : children) ++parents[child];

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
    if (done == elements_.size()) return checkParts(below, ready);

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

}  // namespace metrolux::core::mitsuba
