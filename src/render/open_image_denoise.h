#pragma once
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace metrolux::core {

/// Open Image Denoise of the system, versions 1 and 2, loaded when it is needed: nothing of it is linked.
class OpenImageDenoise {
  public:
    virtual ~OpenImageDenoise() = default;

    /// Null where it is not installed. The environment variable METROLUX_OIDN names the library's file, or
    /// says `off`. Throws Error when a file that it names cannot be loaded, or a library that is found lacks
    /// a function.
    static std::unique_ptr<OpenImageDenoise> load();

    struct Input {
        int width = 0, height = 0;
        std::span<const float> color, albedo, normal;  ///< 3 a pixel; linear, of any brightness
    };
    /// 3 a pixel. Throws Error with what the library says.
    virtual std::vector<float> denoise(const Input& input) const = 0;
    /// "Open Image Denoise 2.3.0".
    virtual std::string name() const = 0;
};

}  // namespace metrolux::core
