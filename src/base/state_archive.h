#pragma once
/// The archives behind base/state.h: cereal's, for a string in memory. Numbers are written as they lie in
/// memory; a checkpoint's header says in which order.

#include "base/math.h"
#include "base/state.h"

#include <cereal/cereal.hpp>
#include <cereal/types/string.hpp>
#include <cereal/types/vector.hpp>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

namespace metrolux::core {

class StateWriter : public cereal::OutputArchive<StateWriter, cereal::AllowEmptyClassElision> {
  public:
    StateWriter() : OutputArchive(this) {}
    void write(const void* data, size_t size) { bytes_.append(static_cast<const char*>(data), size); }
    std::string take() { return std::exchange(bytes_, {}); }

  private:
    std::string bytes_;
};

/// Throws Error at the end of the bytes, and for a size of a container that they cannot fill.
class StateReader : public cereal::InputArchive<StateReader, cereal::AllowEmptyClassElision> {
  public:
    /// `bytes` must outlive the reader.
    explicit StateReader(std::string_view bytes) : InputArchive(this), rest_(bytes) {}
    void read(void* data, size_t size) {
        checkSize(size);
        if (size == 0) return;  // memcpy may not see a null pointer
        std::memcpy(data, rest_.data(), size);
        rest_.remove_prefix(size);
    }
    /// That at least so many bytes are left.
    void checkSize(uint64_t size) const {
        if (size > rest_.size())
            throw Error("saved state: found {} bytes, expected {} more", rest_.size(), size);
    }
    /// To be called when everything has been read.
    void checkEnd() const {
        if (!rest_.empty()) throw Error("saved state: found {} bytes too many", rest_.size());
    }

  private:
    std::string_view rest_;
};

/// Bytes of anything that has serialize().
template <class T>
std::string saveState(const T& object) {
    StateWriter writer;
    writer(object);
    return writer.take();
}
/// Throws Error when the bytes are not those of such an object.
template <class T>
void loadState(std::string_view bytes, T& object) {
    StateReader reader(bytes);
    reader(object);
    reader.checkEnd();
}

template <class T>
requires std::is_arithmetic_v<T>
void CEREAL_SAVE_FUNCTION_NAME(StateWriter& writer, const T& value) { writer.write(&value, sizeof(value)); }
template <class T>
requires std::is_arithmetic_v<T>
void CEREAL_LOAD_FUNCTION_NAME(StateReader& reader, T& value) {
    if constexpr (std::is_same_v<T, bool>) {
        uint8_t byte = 0;
        reader.read(&byte, 1);
        value = byte != 0;
    } else {
        reader.read(&value, sizeof(value));
    }
}
template <class T>
void CEREAL_SAVE_FUNCTION_NAME(StateWriter& writer, const cereal::BinaryData<T>& data) {
    writer.write(data.data, static_cast<size_t>(data.size));
}
template <class T>
void CEREAL_LOAD_FUNCTION_NAME(StateReader& reader, cereal::BinaryData<T>& data) {
    reader.read(data.data, static_cast<size_t>(data.size));
}
template <class T>
void CEREAL_SAVE_FUNCTION_NAME(StateWriter& writer, const cereal::SizeTag<T>& tag) {
    writer(static_cast<uint64_t>(tag.size));
}
/// Elements have one byte at least.
template <class T>
void CEREAL_LOAD_FUNCTION_NAME(StateReader& reader, cereal::SizeTag<T>& tag) {
    uint64_t size = 0;
    reader(size);
    reader.checkSize(size);
    tag.size = static_cast<cereal::size_type>(size);
}

}  // namespace metrolux::core

CEREAL_SETUP_ARCHIVE_TRAITS(metrolux::core::StateReader, metrolux::core::StateWriter)

namespace IMATH_INTERNAL_NAMESPACE {

template <class Archive, class T>
void serialize(Archive& archive, Vec2<T>& v) {
    archive(v.x, v.y);
}
template <class Archive, class T>
void serialize(Archive& archive, Vec3<T>& v) {
    archive(v.x, v.y, v.z);
}

}  // namespace IMATH_INTERNAL_NAMESPACE
