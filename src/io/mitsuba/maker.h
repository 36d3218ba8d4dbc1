#pragma once
/// Elements of the object tree that other formats than Mitsuba's make.

#include "io/mitsuba/properties.h"

namespace metrolux::core::mitsuba {

/// The same map with the inverse of its matrix, not the product of inverses: what a file can say.
inline core::Transform settledMap(const core::Transform& map) {
    double rows[4][4];
    for (int i = 0; i < 16; ++i) rows[i / 4][i % 4] = map.at(i / 4, i % 4);
    return core::Transform::fromRows(rows);
}

/// Collects the parameters of one element.
class Maker {
  public:
    Maker(const std::string& tag, const std::string& type, const Location& location)
        : element_(std::make_shared<Element>()) {
        element_->tag = tag;
        element_->type = type;
        element_->location = location;
    }
    template <class T>
    Maker& with(const std::string& name, T value) {
        element_->named.emplace_back(name, Property{std::move(value), element_->location, false, order_++});
        return *this;
    }
    Maker& containing(ElementPtr child) {
        if (child)
            element_->children.push_back(Property{std::move(child), element_->location, false, order_++});
        return *this;
    }
    Maker& id(const std::string& id) {
        element_->id = id;
        return *this;
    }
    ElementPtr done() const { return element_; }

  private:
    std::shared_ptr<Element> element_;
    int order_ = 0;
};

}  // namespace metrolux::core::mitsuba
