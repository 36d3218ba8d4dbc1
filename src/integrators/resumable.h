#pragma once
#include "base/state_archive.h"
#include "integrators/integrator.h"

namespace metrolux::core {

/// An integrator whose state is what its serialize(Archive&) names.
template <class Derived, class Base = Integrator>
class Resumable : public Base {
  public:
    using Base::Base;
    void saveState(StateWriter& writer) const final { writer(static_cast<const Derived&>(*this)); }
    void loadState(StateReader& reader) final { reader(static_cast<Derived&>(*this)); }
};

}  // namespace metrolux::core
