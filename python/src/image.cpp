/// Reading, writing, showing and comparing images.

#include "image.h"

#include "arrays.h"
#include "unlocked.h"

#include <pybind11/stl/filesystem.h>

namespace metrolux::python {
namespace {

/// Errors of an image, and the images that they are of.
struct Comparison {
    Pixels a, b;
    double epsilon;
    Difference difference;
    Comparison(const py::handle& image, const py::handle& reference, double e)
        : a(image, "image"), b(reference, "reference"), epsilon(e) {
        const Unlocked unlocked;
        difference = compare(a.view(), b.view(), epsilon);
    }
};

py::bytes pngOf(const py::handle& array, double exposure, const std::string& curve) {
    const Pixels pixels(array, "image");
    const std::string bytes = [&] {
        const Unlocked unlocked;
        return encodePng(pixels.view(), {exposure, curve});
    }();
    return bytes;
}

py::object read(const std::filesystem::path& file) {
    Image image = [&] {
        const Unlocked unlocked;
        return readImage(file);
    }();
    return imageOf(std::move(image));
}

void write(const std::filesystem::path& file, const py::handle& array, double exposure,
           const std::string& curve) {
    const Pixels pixels(array, "image");
    const Unlocked unlocked;
    writeImage(file, pixels.view(), {exposure, curve});
}

py::object heatMapOf(const Comparison& c) {
    Image map = [&] {
        const Unlocked unlocked;
        return heatMap(c.a.view(), c.b.view(), c.epsilon);
    }();
    py::object image = imageOf(std::move(map));
    image.attr("curve") = "none";
    return image;
}

template <auto Member>
auto get(const Comparison& c) {
    return c.difference.*Member;
}

std::string textOf(const Comparison& c) {
    char text[160];
    std::snprintf(text, sizeof text,
                  "<metrolux.Comparison relMSE %.6g, trimmed %.6g, sMAPE %.6g, bias %.4f %% +- %.4f %%>",
                  c.difference.relMse, c.difference.trimmedRelMse, c.difference.smape,
                  100 * c.difference.bias, 100 * c.difference.biasError);
    return text;
}

void defineComparison(py::module_& module) {
    using D = Difference;
    py::class_<Comparison> type(module, "Comparison", R"(How far an image is from a reference.

Means are over pixels and color channels; pixels that are not finite in either image are left out and counted.)");
    type.attr("__module__") = "metrolux";
    type.def_property_readonly("mse", &get<&D::mse>, "mean (a-b)^2")
        .def_property_readonly("rel_mse", &get<&D::relMse>, "mean (a-b)^2 / (b^2 + epsilon)")
        .def_property_readonly("trimmed_rel_mse", &get<&D::trimmedRelMse>,
                               "rel_mse without the 0.1 % of the pixels where it is largest")
        .def_property_readonly("smape", &get<&D::smape>, "mean 2|a-b| / (|a|+|b|), from 0 to 2")
        .def_property_readonly("bias", &get<&D::bias>, "(mean a - mean b) / mean b")
        .def_property_readonly(
            "bias_error", &get<&D::biasError>,
            "standard error of the bias, from tiles of 16x16 pixels; nan with fewer than two")
        .def_property_readonly("mean", &get<&D::meanA>, "of the image")
        .def_property_readonly("mean_reference", &get<&D::meanB>, "of the reference")
        .def_property_readonly("pixels", &get<&D::pixels>, "that were compared")
        .def_property_readonly("non_finite", &get<&D::nonFinite>, "pixels that were left out")
        .def_property_readonly("heat_map", &heatMapOf, R"(Display colors of the relative error of each pixel.

float32 (height, width, 3) in [0, 1]: black 0.001, blue, violet, orange, yellow, white 1; green where a pixel is
not finite. To be shown as it is, by matplotlib's imshow for example.)")
        .def("__repr__", &textOf);
}

}  // namespace

void defineImages(py::module_& module) {
    defineComparison(module);
    module.def("read", &read, py::arg("file"),
               R"(Reads EXR, HDR, PNG, JPEG, BMP, TGA, TIFF, PFM or PPM; integer pixels become linear.

An Image, float32 (height, width, channels).)");
    module.def(
        "write", &write, py::arg("file"), py::arg("image"), py::kw_only(), py::arg("exposure") = 0.0,
        py::arg("curve") = "srgb",
        R"(Writes float (height, width, 3), or gray, to .exr (linear) or .png (through exposure and curve).

exposure: in stops. curve: srgb clips, filmic rolls off highlights. The file is replaced as a whole or not at all.)");
    module.def("png", &pngOf, py::arg("image"), py::kw_only(), py::arg("exposure") = 0.0,
               py::arg("curve") = "srgb", "The bytes of the .png that write() would write.");
    module.def(
        "compare", [](const py::handle& a, const py::handle& b, double e) { return Comparison(a, b, e); },
        py::arg("image"), py::arg("reference"), py::kw_only(), py::arg("epsilon") = kDefaultEpsilon,
        R"(A Comparison of two images of the same shape, float (height, width, channels).

epsilon keeps black pixels from counting without limit in rel_mse.)");
}

}  // namespace metrolux::python
