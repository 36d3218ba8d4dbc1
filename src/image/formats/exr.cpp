/// OpenEXR: scan lines and tiles of the first part, whatever they are compressed with.

#include "base/error.h"
#include "image/formats/decoder.h"
#include "image/formats/encoder.h"

#include <Imath/ImathBox.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfChromaticitiesAttribute.h>
#include <OpenEXR/ImfCompression.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfIntAttribute.h>
#include <OpenEXR/ImfMatrixAttribute.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfThreading.h>

#include <algorithm>
#include <cstring>
#include <ctime>
#include <istream>
#include <mutex>
#include <optional>
#include <thread>
#include <tuple>

namespace metrolux::core {
namespace {

/// From this size on, OpenEXR compresses and decompresses with threads of its own.
constexpr int64_t kParallelPixels = int64_t{1} << 20;

int threadsFor(int64_t pixels) {
    if (pixels < kParallelPixels) return 0;
    static std::once_flag once;
    std::call_once(once,
                   [] { Imf::setGlobalThreadCount(static_cast<int>(std::thread::hardware_concurrency())); });
    return Imf::globalThreadCount();
}

/// Runs `action`; what OpenEXR throws becomes an Error.
template <class Action>
auto guarded(const Action& action) {
    try {
        return action();
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const Error&) {
        throw;
    } catch (const std::exception& error) {
        throw Error(error.what());
    }
}

class StreamInput final : public Imf::IStream {
  public:
    explicit StreamInput(std::istream& stream) : Imf::IStream("image"), stream_(stream) {}
    bool read(char* bytes, int count) override {
        stream_.read(bytes, count);
        if (stream_.gcount() != count) throw Error("the file ends too early");
        return true;
    }
    uint64_t tellg() override { return static_cast<uint64_t>(stream_.tellg()); }
    void seekg(uint64_t position) override {
        stream_.clear();
        stream_.seekg(static_cast<std::streamoff>(position));
    }
    void clear() override { stream_.clear(); }

  private:
    std::istream& stream_;
};

class BytesOutput final : public Imf::OStream {
  public:
    BytesOutput() : Imf::OStream("image") {}
    void write(const char* bytes, int count) override {
        const size_t size = static_cast<size_t>(count);
        if (bytes_.size() < position_ + size) bytes_.resize(position_ + size);
        std::memcpy(bytes_.data() + position_, bytes, size);
        position_ += size;
    }
    uint64_t tellp() override { return position_; }
    void seekp(uint64_t position) override { position_ = position; }
    std::string take() { return std::move(bytes_); }

  private:
    std::string bytes_;
    size_t position_ = 0;
};

/// Attributes whose names in other formats are better known.
constexpr std::pair<const char*, const char*> kNames[] = {{"capDate", "DateTime"},
                                                          {"pixelAspectRatio", "PixelAspectRatio"}};

const char* compressionName(Imf::Compression compression) {
    constexpr const char* kCompressions[] = {"none",  "rle", "zips", "zip",  "piz",
                                             "pxr24", "b44", "b44a", "dwaa", "dwab"};
    const auto index = static_cast<size_t>(compression);
    return index < std::size(kCompressions) ? kCompressions[index] : "unknown";
}

template <class T>
const T* valueOf(const Imf::Attribute& attribute) {
    const auto* typed = dynamic_cast<const Imf::TypedAttribute<T>*>(&attribute);
    return typed ? &typed->value() : nullptr;
}

std::optional<MetadataValue> metadataValue(const Imf::Attribute& attribute) {
    if (const auto* text = valueOf<std::string>(attribute)) return *text;
    if (const auto* integer = valueOf<int>(attribute)) return *integer;
    if (const auto* number = valueOf<float>(attribute)) return double{*number};
    if (const auto* number = valueOf<double>(attribute)) return *number;
    if (const auto* matrix = valueOf<Imath::M44f>(attribute)) {
        Matrix values;
        std::copy_n(matrix->getValue(), values.size(), values.begin());
        return values;
    }
    return std::nullopt;
}

Metadata metadataOf(const Imf::Header& header) {
    Metadata result{{"compression", std::string(compressionName(header.compression()))}};
    for (auto it = header.begin(); it != header.end(); ++it) {
        std::string name = it.name();
        if (name == "type") continue;
        for (const auto& [own, known] : kNames)
            if (name == own) name = known;
        if (auto value = metadataValue(it.attribute())) result.emplace_back(name, *std::move(value));
    }
    return result;
}

/// The order of channels: those without a layer first, and R, G, B, A as one says them.
std::tuple<std::string, size_t, std::string> channelOrder(const std::string& name) {
    const size_t dot = name.rfind('.');
    const std::string layer = dot == std::string::npos ? "" : name.substr(0, dot);
    const std::string own = dot == std::string::npos ? name : name.substr(dot + 1);
    static const std::string known = "RGBA";
    const size_t rank = own.size() == 1 ? known.find(own[0]) : std::string::npos;
    return {layer, std::min(rank, known.size()), own};
}

class ExrDecoder final : public ImageDecoder {
  public:
    explicit ExrDecoder(std::istream& stream) : stream_(stream) {
        refuseDeep(stream);
        guarded([&] {
            // Tables whose size the header claims are allocated with it.
            Imf::Header::setMaxImageSize(kLargestSide, kLargestSide);
            const Imf::MultiPartInputFile file(stream_, 0);
            readHeader(file.header(0));
        });
    }

    std::vector<float> readPixels() override {
        return guarded([&] {
            stream_.seekg(0);
            Imf::InputFile file(stream_, threadsFor(int64_t{info_.width} * info_.height));
            const Imath::Box2i window = file.header().dataWindow();
            const size_t count = info_.channels.size(), width = static_cast<size_t>(info_.width);
            std::vector<float> pixels(width * static_cast<size_t>(info_.height) * count);
            Imf::FrameBuffer buffer;
            for (size_t c = 0; c < count; ++c)
                buffer.insert(info_.channels[c],
                              Imf::Slice::Make(Imf::FLOAT, pixels.data() + c, window, count * sizeof(float),
                                               width * count * sizeof(float)));
            file.setFrameBuffer(buffer);
            file.readPixels(window.min.y, window.max.y);
            return pixels;
        });
    }

  private:
    /// Bit 11 of the version says that some part has samples in depth.
    static void refuseDeep(std::istream& stream) {
        const std::string start = readBytes(stream, 8);
        if (start[5] & 0x08) throw Error("it has deep pixels, expected flat ones");
        stream.seekg(0);
    }

    void readHeader(const Imf::Header& header) {
        info_.format = "openexr";
        const Imath::Box2i data = header.dataWindow(), display = header.displayWindow();
        info_.width = data.max.x - data.min.x + 1;
        info_.height = data.max.y - data.min.y + 1;
        if (data != display)
            info_.place = {data.min.x - display.min.x, data.min.y - display.min.y,
                           display.max.x - display.min.x + 1, display.max.y - display.min.y + 1};
        isFloat_ = true;
        valueBytes_ = 2;
        for (auto it = header.channels().begin(); it != header.channels().end(); ++it) {
            const Imf::Channel& channel = it.channel();
            if (channel.xSampling != 1 || channel.ySampling != 1)
                throw Error("channel '{}' has {}x{} subsampling, expected none", it.name(), channel.xSampling,
                            channel.ySampling);
            info_.channels.emplace_back(it.name());
            if (channel.type != Imf::HALF) valueBytes_ = 4;
        }
        std::sort(info_.channels.begin(), info_.channels.end(),
                  [](const auto& a, const auto& b) { return channelOrder(a) < channelOrder(b); });
        info_.metadata = metadataOf(header);
    }

    StreamInput stream_;
};

void insert(Imf::Header& header, const std::string& name, const MetadataValue& value) {
    if (const auto* text = std::get_if<std::string>(&value)) header.insert(name, Imf::StringAttribute(*text));
    if (const auto* number = std::get_if<double>(&value)) header.insert(name, Imf::DoubleAttribute(*number));
    if (const auto* integer = std::get_if<int>(&value)) header.insert(name, Imf::IntAttribute(*integer));
    if (const auto* m = std::get_if<Matrix>(&value)) {
        Imath::M44f matrix;
        std::copy(m->begin(), m->end(), matrix.getValue());
        header.insert(name, Imf::M44fAttribute(matrix));
    }
}

/// The local time, as capDate has it.
std::string timeText() {
    const std::time_t now = std::time(nullptr);
    std::tm local{};
    localtime_r(&now, &local);
    char text[32];
    return {text, std::strftime(text, sizeof text, "%Y:%m:%d %H:%M:%S", &local)};
}

}  // namespace

std::unique_ptr<ImageDecoder> openExr(std::istream& stream) { return std::make_unique<ExrDecoder>(stream); }

std::string encodeExrChannels(int width, int height, const ImagePlace& place,
                              const std::vector<EncodedChannel>& channels, const Metadata& metadata) {
    return guarded([&] {
        const Imath::V2i origin(place.x, place.y);
        const Imath::Box2i data(origin, origin + Imath::V2i(width - 1, height - 1));
        const Imath::Box2i display(Imath::V2i(0), place.isCrop()
                                                      ? Imath::V2i(place.fullWidth - 1, place.fullHeight - 1)
                                                      : Imath::V2i(width - 1, height - 1));
        Imf::Header header(display, data);
        header.compression() = Imf::ZIP_COMPRESSION;
        // The defaults are ITU-R BT.709 with D65.
        header.insert("chromaticities", Imf::ChromaticitiesAttribute(Imf::Chromaticities()));
        header.insert("capDate", Imf::StringAttribute(timeText()));
        for (const auto& [name, value] : metadata) insert(header, name, value);

        Imf::FrameBuffer buffer;
        for (const EncodedChannel& channel : channels) {
            header.channels().insert(channel.name, Imf::Channel(Imf::FLOAT));
            const size_t bytes = channel.stride * sizeof(float);
            buffer.insert(channel.name, Imf::Slice::Make(Imf::FLOAT, channel.values, data, bytes,
                                                         bytes * static_cast<size_t>(width)));
        }
        BytesOutput output;
        {
            Imf::OutputFile file(output, header, threadsFor(int64_t{width} * height));
            file.setFrameBuffer(buffer);
            file.writePixels(height);
        }
        return output.take();
    });
}

}  // namespace metrolux::core
