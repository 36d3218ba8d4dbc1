#pragma once
#include "api/converter.h"
#include "io/mitsuba/parser.h"

#include <optional>
#include <unordered_map>

namespace metrolux::core::api {

/// Everything that a scene says, by the paths that SceneTree::set() takes, of an element that several refer
/// to once. The sensor is `now` in place of `before`.
Object::Values valuesOf(const mitsuba::Element& root, const mitsuba::Element* before,
                        const mitsuba::Element& now);

/// A copy of a parsed scene, to be changed by paths. A path is made of names with points between: directly in
/// the scene an id or else the tag, below it the name in the parent or else the tag. Where a name repeats,
/// "_2",
/// "_3" ... follow it.
class SceneTree {
  public:
    /// With the sensor `now` in place of `before`, which is in `scene`.
    SceneTree(const mitsuba::ParsedScene& scene, const mitsuba::ElementPtr& before,
              const mitsuba::ElementPtr& now);
    /// Replaces what is at the path, or adds to the element that all of the path but its last name leads to.
    /// Throws Error.
    void set(const std::string& path, const Value& value);
    /// Whether all that was set is in the sensor (its film included), so that a view of the scene will do:
    /// not where the sensor is in a medium, which is among the scene's. After finish().
    bool onlySensorChanged() const;
    bool filmChanged() const { return film_; }
    const std::shared_ptr<mitsuba::Element>& sensor() const { return sensor_; }
    /// The result, references linked. To be called once. Throws Error.
    mitsuba::ParsedScene finish();

  private:
    struct Target;
    std::shared_ptr<mitsuba::Element> copyOf(const mitsuba::ElementPtr& element);
    Target find(const std::string& path) const;
    void noteWhere(const mitsuba::Element& element, const mitsuba::Property* place);

    mitsuba::ParsedScene scene_;
    std::unordered_map<const mitsuba::Element*, std::shared_ptr<mitsuba::Element>> copies_;  ///< by original
    std::shared_ptr<mitsuba::Element> root_, sensor_;
    std::optional<Converter> converter_;
    bool elsewhere_ = false, film_ = false;
};

}  // namespace metrolux::core::api
