#pragma once
#include "io/mitsuba/references.h"

#include <metrolux/object.h>

#include <unordered_set>

namespace metrolux::core::api {

/// Makes the elements of a scene file out of objects, so that the loader takes both alike. All throw Error
/// that names the object by its path ("scene:lamp.emitter").
class Converter {
  public:
    /// `file` begins all messages. The positions of what is made begin with `firstOrder`, which is above
    /// those of what it is put beside.
    explicit Converter(std::string file, int firstOrder = 0)
        : file_(std::move(file)), nextOrder_(firstOrder) {}

    std::shared_ptr<mitsuba::Element> convert(const Object& object, const std::string& tag,
                                              const std::string& path, const std::string& ownId = {},
                                              int depth = 0);
    /// Whether it becomes an element: references, colors and spectra do not.
    static bool isElement(const Object& object);
    /// The same in place of what an element was: who refers to it refers to the new one. It keeps its id
    /// unless the object brings one.
    void replace(const std::shared_ptr<mitsuba::Element>& element, const Object& object,
                 const std::string& name, const std::string& path);
    /// What a value is under a name of `parent`; references become known, and are linked by
    /// references().resolve(). `property` has the location and the position that it is to have, and is a
    /// child without a name if `isChild`.
    void assign(mitsuba::Element& parent, const std::string& name, bool isChild, const Value& value,
                mitsuba::Property& property, int depth = 0);
    mitsuba::Location locationOf(const std::string& path) const { return {file_, 0, path}; }
    int nextOrder() { return nextOrder_++; }

    mitsuba::References& references() { return references_; }
    const std::unordered_set<const mitsuba::Element*>& made() const { return made_; }

  private:
    using Data = decltype(mitsuba::Property::value);
    /// Where a value is.
    struct Place {
        mitsuba::Element& parent;
        const std::string& name;
        const mitsuba::Property& property;
        bool isChild;
        int depth;
    };
    void fill(const std::shared_ptr<mitsuba::Element>& element, const Object& object, const std::string& tag,
              const std::string& path, const std::string& ownId, int depth);
    void add(mitsuba::Element& parent, const std::string& name, const Value& value, int depth);
    Data of(const Reference& reference, const Place& at);
    Data of(const std::shared_ptr<const Object>& object, const Place& at);

    std::string file_;
    mitsuba::References references_;
    std::unordered_set<const mitsuba::Element*> made_;
    int nextOrder_;
};

}  // namespace metrolux::core::api
