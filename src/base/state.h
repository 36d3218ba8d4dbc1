#pragma once
/// Saving and restoring the state of a computation. A class that has state says so in one function,
///
///     template <class Archive> void serialize(Archive& archive) { archive(a_, b_); }
///
/// which writes to a StateWriter and reads from a StateReader; neither is needed to declare it. What the
/// constructor sets from scene and options is not state. Classes check what they read: a file may come from
/// anywhere.

#include "base/error.h"

#include <cstdint>

namespace metrolux::core {

class StateWriter;  // base/state_archive.h
class StateReader;

/// The elements of a container whose size the constructor has set. Throws Error for another size.
template <class Archive, class Container>
void serializeElements(Archive& archive, Container& elements, const char* what) {
    uint64_t size = elements.size();
    archive(size);
    if (size != elements.size())
        throw Error("saved state: found {} {}, expected {}", size, what, elements.size());
    for (auto& element : elements) archive(element);
}

/// As many elements as there are, but no more than `most`. Throws Error before it makes more.
template <class Archive, class Container>
void serializeAtMost(Archive& archive, Container& elements, size_t most, const char* what) {
    uint64_t size = elements.size();
    archive(size);
    if (size > most) throw Error("saved state: found {} {}, expected at most {}", size, what, most);
    elements.resize(static_cast<size_t>(size));
    for (auto& element : elements) archive(element);
}

/// Throws Error unless `valid`.
inline void checkState(bool valid, const char* expected) {
    if (!valid) throw Error("saved state: expected {}", expected);
}

}  // namespace metrolux::core
