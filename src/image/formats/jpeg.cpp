/// JPEG, baseline and progressive, with libjpeg.

#include "base/error.h"
#include "image/formats/decoder.h"

#include <csetjmp>
#include <cstdio>
#include <istream>
#include <jerror.h>
#include <jpeglib.h>

namespace metrolux::core {
namespace {

/// libjpeg reports an error by a call that may not return: it jumps, over frames that may therefore hold
/// nothing that wants a destructor.
struct JpegErrors : jpeg_error_mgr {
    jmp_buf target;
    char message[JMSG_LENGTH_MAX] = "";

    static void fail(j_common_ptr jpeg) {
        auto* self = static_cast<JpegErrors*>(jpeg->err);
        self->format_message(jpeg, self->message);
        longjmp(self->target, 1);
    }
    /// Warnings are silent, but for the one that the rest of the picture would be made up.
    static void warn(j_common_ptr jpeg, int level) {
        if (level < 0 && jpeg->err->msg_code == JWRN_JPEG_EOF) fail(jpeg);
    }
};

class JpegDecoder final : public ImageDecoder {
  public:
    explicit JpegDecoder(std::istream& stream) : bytes_(readRest(stream)) {
        jpeg_.err = jpeg_std_error(&errors_);
        errors_.error_exit = &JpegErrors::fail;
        errors_.emit_message = &JpegErrors::warn;
        try {
            run([&] {
                jpeg_create_decompress(&jpeg_);
                jpeg_mem_src(&jpeg_, reinterpret_cast<const unsigned char*>(bytes_.data()), bytes_.size());
                jpeg_read_header(&jpeg_, TRUE);
            });
        } catch (...) {
            jpeg_destroy_decompress(&jpeg_);
            throw;
        }
        const bool isCmyk = jpeg_.num_components == 4;
        if (isCmyk) jpeg_.out_color_space = JCS_CMYK;
        info_.format = "jpeg";
        info_.width = static_cast<int>(jpeg_.image_width);
        info_.height = static_cast<int>(jpeg_.image_height);
        info_.channels = defaultChannels(jpeg_.num_components == 1 ? 1 : 3);
    }
    ~JpegDecoder() override { jpeg_destroy_decompress(&jpeg_); }
    JpegDecoder(const JpegDecoder&) = delete;
    JpegDecoder& operator=(const JpegDecoder&) = delete;

    std::vector<float> readPixels() override {
        run([&] { jpeg_start_decompress(&jpeg_); });
        const size_t channels = static_cast<size_t>(jpeg_.output_components);
        const size_t row = static_cast<size_t>(info_.width) * channels;
        std::vector<uint8_t> values(row * static_cast<size_t>(info_.height));
        uint8_t* at = values.data();
        run([&] {
            while (jpeg_.output_scanline < jpeg_.output_height) {
                JSAMPROW target = at + row * jpeg_.output_scanline;
                jpeg_read_scanlines(&jpeg_, &target, 1);
            }
        });
        if (channels == 4) toRgb(values);
        return scaledToOne(std::span<const uint8_t>(values));
    }

  private:
    /// Runs `action`, which has only trivial local variables, and throws what libjpeg reports.
    template <class Action>
    void run(const Action& action) {
        if (setjmp(errors_.target)) throw Error(std::string(errors_.message));
        action();
    }

    /// From inks, stored as what they leave of the light.
    static void toRgb(std::vector<uint8_t>& values) {
        size_t to = 0;
        for (size_t i = 0; i + 3 < values.size(); i += 4)
            for (size_t c = 0; c < 3; ++c)
                values[to++] = static_cast<uint8_t>((values[i + c] * values[i + 3] + 127) / 255);
        values.resize(to);
    }

    std::string bytes_;
    jpeg_decompress_struct jpeg_{};
    JpegErrors errors_{};
};

}  // namespace

std::unique_ptr<ImageDecoder> openJpeg(std::istream& stream) { return std::make_unique<JpegDecoder>(stream); }

}  // namespace metrolux::core
