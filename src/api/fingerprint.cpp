#include "api/object_tree.h"

#include <type_traits>
#include <zlib.h>

namespace metrolux::core::api {
namespace {

using namespace mitsuba;

/// Feeds all that an element says into a checksum.
struct Fingerprint {
    uLong sum = 0;
    size_t bytes = 0;

    void add(const void* data, size_t size) {
        sum = ::crc32_z(sum, static_cast<const Bytef*>(data), size);
        bytes += size;
    }
    void add(const std::string& text) { add(text.c_str(), text.size() + 1); }
    template <class T>
    void add(const T& number) requires std::is_arithmetic_v<T> {
        add(&number, sizeof number);
    }
    template <class T>
    void addAll(const T& numbers) {
        add(numbers.size());
        add(numbers.data(), numbers.size() * sizeof(*numbers.data()));
    }
    void add(const Vec3d& v) { add(&v, sizeof v); }
    void add(const Transform& t) {
        for (int i = 0; i < 16; ++i) add(t.at(i / 4, i % 4));
    }
    void add(const RgbValue& v) { add(&v.value, sizeof v.value); }
    void add(const SpectrumValue& s) {
        addAll(s.wavelengths);
        addAll(s.values);
        add(s.blackbodyKelvin);
    }
    void add(const MeshArrays& m) {
        addAll(m.positions);
        addAll(m.normals);
        addAll(m.uvs);
        addAll(m.triangles);
        for (const auto& a : m.attributes) {
            add(a.name);
            addAll(a.values);
        }
    }
    void add(const PixelArray& p) {
        add(p.width);
        add(p.channels);
        addAll(p.pixels);
    }
    void add(const VoxelArray& v) {
        addAll(v.resolution);
        add(v.channels);
        addAll(v.values);
    }
    void add(const ElementPtr& element) {
        if (element) add(*element);
    }
    void add(const Property& property) {
        add(property.value.index());
        std::visit([this](const auto& value) { add(value); }, property.value);
    }
    void add(const Element& element) {
        add(element.tag);
        add(element.type);
        add(element.id);
        for (const auto& [name, property] : element.named) {
            add(name);
            add(property);
        }
        for (const Property& property : element.children) add(property);
        add(size_t{0});
    }
};

}  // namespace

std::string fingerprintOf(const Element& element) {
    Fingerprint fingerprint;
    fingerprint.add(element);
    return fmt::format("{} bytes, checksum {:08x}", fingerprint.bytes, fingerprint.sum);
}

}  // namespace metrolux::core::api
