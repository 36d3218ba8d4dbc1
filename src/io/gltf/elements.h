#pragma once
/// Elements of the object tree that other formats than Mitsuba's make.

#include "io/mitsuba/properties.h"

namespace metrolux::core::gltf {

/// Collects the parameters of one element.
class Maker {
  public:
    Maker(const std::string& tag, const std::string& type, const mitsuba::Location& location)
        : element_(std::make_shared<mitsuba::Element>()) {
        element_->tag = tag;
        element_->type = type;
        element_->location = location;
    }
    template <class T>
    Maker& with(const std::string& name, T value) {
        element_->named.emplace_back(
            name, mitsuba::Property{std::move(value), element_->location, false, order_++});
        return *this;
    }
    Maker& containing(mitsuba::ElementPtr child) {
        if (child)
            element_->children.push_back(
                mitsuba::Property{std::move(child), element_->location, false, order_++});
        return *this;
    }
    Maker& id(const std::string& id) {
        element_->id = id;
        return *this;
    }
    mitsuba::ElementPtr done() const { return element_; }

  private:
    std::shared_ptr<mitsuba::Element> element_;
    int order_ = 0;
};

}  // namespace metrolux::core::gltf
