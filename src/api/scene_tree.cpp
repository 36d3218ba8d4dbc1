#include "api/scene_tree.h"

#include "api/internals.h"
#include "base/suggest.h"

#include <algorithm>
#include <unordered_set>

namespace metrolux::core::api {
namespace {

using namespace mitsuba;

const ElementPtr* elementOf(const Property& property) {
    const ElementPtr* element = std::get_if<ElementPtr>(&property.value);
    return element && *element ? element : nullptr;
}

struct Name {
    std::string text;
    const Property* property;
    bool isChild;  ///< of Element::children
};

/// What is directly in an element, by the names that paths have.
std::vector<Name> namesIn(const Element& parent) {
    std::vector<Name> result;
    std::unordered_map<std::string, int> count;
    const auto add = [&](const std::string& name, const Property& property, bool isChild) {
        const int earlier = count[name]++;
        result.push_back({earlier == 0 ? name : fmt::format("{}_{}", name, earlier + 1), &property, isChild});
    };
    const auto idOr = [&](const Property& property, const std::string& name) {
        const bool isList = parent.tag == "scene" || parent.type == "shapegroup";
        const ElementPtr* element = elementOf(property);
        if (isList && element && !(*element)->id.empty()) return (*element)->id;
        return name.empty() && element ? (*element)->tag : name;
    };
    for (const auto& [name, property] : parent.named) add(idOr(property, name), property, false);
    for (const Property& property : parent.children) add(idOr(property, ""), property, true);
    return result;
}

/// An element of a copy, which is ours to change.
std::shared_ptr<Element> own(const ElementPtr& element) { return std::const_pointer_cast<Element>(element); }

/// Calls `visit` with each element below `element` and itself, once.
template <class Visit>
void forEach(const ElementPtr& element, std::unordered_set<const Element*>& seen, const Visit& visit) {
    if (!seen.insert(element.get()).second) return;
    visit(element);
    const auto descend = [&](const Property& property) {
        if (const ElementPtr* child = elementOf(property)) forEach(*child, seen, visit);
    };
    for (const auto& entry : element->named) descend(entry.second);
    for (const Property& property : element->children) descend(property);
}

/// The value of a property that is no element.
Value valueOf(const Property& property) {
    struct Convert {
        Value operator()(bool v) const { return v; }
        Value operator()(int64_t v) const { return v; }
        Value operator()(double v) const { return v; }
        Value operator()(const std::string& v) const { return v; }
        Value operator()(const Vec3d& v) const { return Vector{v.x, v.y, v.z}; }
        Value operator()(const core::Transform& t) const { return Internals::transform(t); }
        Value operator()(const RgbValue& v) const {
            return Color{static_cast<double>(v.value[0]), static_cast<double>(v.value[1]),
                         static_cast<double>(v.value[2])};
        }
        Value operator()(const SpectrumValue& s) const {
            if (s.blackbodyKelvin > 0)
                return Blackbody{static_cast<double>(s.blackbodyKelvin), static_cast<double>(s.values[0])};
            return Spectrum{{s.wavelengths.begin(), s.wavelengths.end()}, {s.values.begin(), s.values.end()}};
        }
        Value operator()(const MeshArrays& m) const {
            if (m.isMesh) return std::static_pointer_cast<const Mesh>(m.owner);
            const auto copy = [](const auto& values) { return std::vector(values.begin(), values.end()); };
            Mesh mesh;
            mesh.positions = copy(m.positions), mesh.triangles = copy(m.triangles);
            mesh.normals = copy(m.normals), mesh.uvs = copy(m.uvs);
            for (const MeshArrays::Attribute& a : m.attributes)
                mesh.attributes.push_back({a.name, a.channels, copy(a.values)});
            return mesh;
        }
        Value operator()(const PixelArray& p) const {
            if (p.isImage) return std::static_pointer_cast<const Image>(p.owner);
            return Image{{p.pixels.begin(), p.pixels.end()}, p.height, p.width, p.channels};
        }
        Value operator()(const VoxelArray&) const { return false; }
        Value operator()(const ElementPtr&) const { return false; }
    };
    return std::visit(Convert{}, property.value);
}

/// The public Transform has an inverse, and volumes are in files there.
bool isListed(const Property& property) {
    if (std::holds_alternative<VoxelArray>(property.value)) return false;
    const auto* map = std::get_if<core::Transform>(&property.value);
    return !(map && map->isSingular()) && !std::holds_alternative<ElementPtr>(property.value);
}

class Lister {
  public:
    Lister(const Element& root, const Element* before, const Element& now) : before_(before), now_(now) {
        for (const Name& name : namesIn(root))
            if (const ElementPtr* element = elementOf(*name.property)) atTop_.insert(element->get());
        list(root, "", true);
    }
    Object::Values values;

  private:
    void list(const Element& element, const std::string& prefix, bool isRoot) {
        if (!seen_.insert(&element).second) return;
        for (const Name& name : namesIn(element)) {
            const ElementPtr* child = elementOf(*name.property);
            if (!child) {
                if (isListed(*name.property))
                    values.emplace_back(prefix + name.text, valueOf(*name.property));
            } else if (isRoot || !atTop_.contains(child->get())) {
                list(child->get() == before_ ? now_ : **child, prefix + name.text + ".", false);
            }
        }
    }

    const Element* before_;
    const Element& now_;
    std::unordered_set<const Element*> atTop_, seen_;
};

/// Three numbers are a color where a color or a number was.
Value asBefore(const Property* before, const Value& value) {
    const auto* v = std::get_if<Vector>(&value.data());
    if (!v || !before) return value;
    const ElementPtr* element = elementOf(*before);
    const bool isColor = std::holds_alternative<RgbValue>(before->value) ||
                         std::holds_alternative<SpectrumValue>(before->value) ||
                         std::holds_alternative<double>(before->value) ||
                         std::holds_alternative<int64_t>(before->value) ||
                         (element && ((*element)->tag == "texture" || (*element)->tag == "volume"));
    return isColor ? Value(Color{v->x, v->y, v->z}) : value;
}

int lastOrder(const ElementPtr& root) {
    int last = 0;
    std::unordered_set<const Element*> seen;
    forEach(root, seen, [&](const ElementPtr& element) {
        for (const auto& entry : element->named) last = std::max(last, entry.second.order);
        for (const Property& property : element->children) last = std::max(last, property.order);
    });
    return last;
}

}  // namespace

Object::Values valuesOf(const Element& root, const Element* before, const Element& now) {
    return std::move(Lister(root, before, now).values);
}

SceneTree::SceneTree(const ParsedScene& scene, const ElementPtr& before, const ElementPtr& now)
    : scene_(scene) {
    if (now) {
        sensor_ = copyOf(now);
        if (before && sensor_->id.empty()) sensor_->id = before->id;
        copies_[before.get()] = sensor_;
    }
    root_ = copyOf(scene.root);
    scene_.referenced.clear();
    for (const Element* element : scene.referenced)
        if (const auto copy = copies_.find(element); copy != copies_.end())
            scene_.referenced.insert(copy->second.get());
    converter_.emplace(root_->location.file, lastOrder(root_) + 1);
}

std::shared_ptr<Element> SceneTree::copyOf(const ElementPtr& element) {
    if (const auto found = copies_.find(element.get()); found != copies_.end()) return found->second;
    auto result = std::make_shared<Element>(*element);
    copies_[element.get()] = result;
    const auto renew = [this](Property& property) {
        property.used = false;
        if (const ElementPtr* child = elementOf(property)) property.value = ElementPtr(copyOf(*child));
    };
    for (auto& entry : result->named) renew(entry.second);
    for (Property& property : result->children) renew(property);
    return result;
}

/// Where a path leads: a property of `parent`, or null for a name that is new there.
struct SceneTree::Target {
    std::shared_ptr<Element> parent;
    std::string name;  ///< in its parent, empty for a child without one
    const Property* property;
    bool isChild;
};

SceneTree::Target SceneTree::find(const std::string& path) const {
    std::shared_ptr<Element> parent = root_;
    std::string rest = path;
    const auto fail = [&](const std::vector<Name>& names) {
        std::vector<std::string> known;
        for (const Name& name : names) known.push_back(name.text);
        const std::string nearest = nearestName(rest.substr(0, rest.find('.')), known);
        return Error("{}: found the path \"{}\", and nothing with the name \"{}\"{}", root_->location.file,
                     path, rest.substr(0, rest.find('.')),
                     nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest));
    };
    while (true) {
        const std::vector<Name> names = namesIn(*parent);
        const Name* best = nullptr;  // names may have points in them: the longest one that fits
        for (const Name& name : names) {
            const bool fits = rest.starts_with(name.text) &&
                              (rest.size() == name.text.size() || rest[name.text.size()] == '.');
            if (fits && (!best || name.text.size() > best->text.size())) best = &name;
        }
        if (!best) {
            if (rest.empty() || rest.find('.') != std::string::npos) throw fail(names);
            return {parent, rest, nullptr, parent == root_};
        }
        if (rest.size() == best->text.size()) {
            std::string name = best->isChild ? "" : best->text;
            for (const auto& entry : parent->named)
                if (&entry.second == best->property) name = entry.first;
            return {parent, name, best->property, best->isChild};
        }
        rest = rest.substr(best->text.size() + 1);
        const ElementPtr* element = elementOf(*best->property);
        if (!element)
            throw Error("{}: found the path \"{}\", but nothing is inside of \"{}\"", root_->location.file,
                        path, best->text);
        parent = own(*element);
    }
}

void SceneTree::noteWhere(const Element& element, const Property* place) {
    bool isInSensor = false;
    const auto look = [&](const ElementPtr& start, bool& found) {
        std::unordered_set<const Element*> seen;
        forEach(start, seen, [&](const ElementPtr& e) {
            if (e.get() == &element) found = true;
        });
    };
    if (sensor_) look(sensor_, isInSensor);
    const ElementPtr* whole = place ? elementOf(*place) : nullptr;
    if (!isInSensor && !(whole && *whole == sensor_)) {
        elsewhere_ = true;
        return;
    }
    if (whole && ((*whole)->tag == "film" || *whole == sensor_)) film_ = true;
    for (const auto& name : namesIn(*sensor_))
        if (const ElementPtr* child = elementOf(*name.property); child && (*child)->tag == "film")
            look(*child, film_);
}

void SceneTree::set(const std::string& path, const Value& value) {
    const Target target = find(path);
    noteWhere(*target.parent, target.property);
    const auto* object = std::get_if<std::shared_ptr<const Object>>(&value.data());
    const bool isElement = object && *object && Converter::isElement(**object);
    if (const ElementPtr* old = target.property ? elementOf(*target.property) : nullptr; old && isElement) {
        converter_->replace(own(*old), **object, target.name.empty() ? (*old)->tag : target.name, path);
        return;
    }
    const std::string name = target.name.empty() ? path : target.name;
    Property property{{},
                      converter_->locationOf(path),
                      false,
                      target.property ? target.property->order : converter_->nextOrder()};
    converter_->assign(*target.parent, name, target.isChild, asBefore(target.property, value), property);
    if (target.isChild && !std::holds_alternative<ElementPtr>(property.value))
        throw Error("{}: found a value, expected an object or a reference", property.location.str());
    if (target.property)
        const_cast<Property&>(*target.property) = std::move(property);  // of target.parent, which is ours
    else if (target.isChild)
        target.parent->children.push_back(std::move(property));
    else
        target.parent->named.emplace_back(name, std::move(property));
}

bool SceneTree::onlySensorChanged() const {
    if (elsewhere_) return false;
    const std::vector<Name> names = namesIn(*sensor_);
    return std::none_of(names.begin(), names.end(), [](const Name& name) {
        const ElementPtr* child = elementOf(*name.property);
        return child && (*child)->tag == "medium";
    });
}

ParsedScene SceneTree::finish() {
    References& references = converter_->references();
    std::unordered_set<const Element*> seen;
    forEach(root_, seen, [&](const ElementPtr& element) {
        if (!converter_->made().contains(element.get())) references.addElement(own(element));
    });
    references.resolve();
    scene_.referenced.insert(references.referenced().begin(), references.referenced().end());
    scene_.root = root_;
    return std::move(scene_);
}

}  // namespace metrolux::core::api
