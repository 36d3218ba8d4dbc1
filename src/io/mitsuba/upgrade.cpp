#include "io/mitsuba/upgrade.h"

#include <algorithm>
#include <cctype>
#include <set>

namespace metrolux::core::mitsuba {
namespace {

bool isLower(char c) { return std::islower(static_cast<unsigned char>(c)); }
bool isUpper(char c) { return std::isupper(static_cast<unsigned char>(c)); }
char lower(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }

class Upgrade {
  public:
    Upgrade(Element& element, std::vector<std::string>& warnings) : element_(element), warnings_(warnings) {}

    void run() {
        renameAll();
        const std::string& tag = element_.tag;
        if (tag == "bsdf") bsdf();
        if (tag == "texture") texture();
        if (tag == "film") film();
        if (tag == "sampler") sampler();
        if (tag == "emitter" || tag == "texture") drop({"cache"}, "caches are not kept");
    }

  private:
    /// To snake case. 0.6 does not know the names of 3.x: where both are there, its own holds.
    void renameAll() {
        std::set<std::string> renamed;
        for (const auto& [name, property] : element_.named)
            if (snakeCase(name) != name) renamed.insert(snakeCase(name));
        std::erase_if(element_.named, [&](const auto& entry) {
            if (!renamed.contains(entry.first)) return false;
            const char* const reason =
                "ignored: the property is there in the spelling of 0.x too, which holds";
            warnings_.emplace_back(element_.error(entry.second, reason).what());
            return true;
        });
        for (auto& entry : element_.named) entry.first = snakeCase(entry.first);
    }

    void warn(const std::string& message) { warnings_.emplace_back(element_.error(message).what()); }

    Property* find(const std::string& name) {
        for (auto& entry : element_.named)
            if (entry.first == name) return &entry.second;
        return nullptr;
    }
    void rename(const std::string& from, const std::string& to) {
        for (auto& entry : element_.named)
            if (entry.first == from) entry.first = to;
    }
    void erase(const std::string& name) {
        std::erase_if(element_.named, [&](const auto& entry) { return entry.first == name; });
    }
    void drop(const std::vector<std::string>& names, const std::string& reason) {
        std::string found;
        for (const std::string& name : names) {
            if (!find(name)) continue;
            found += fmt::format("{}\"{}\"", found.empty() ? "" : ", ", name);
            erase(name);
        }
        if (!found.empty()) warn(fmt::format("ignored: {} ({})", found, reason));
    }
    void changeType(const std::string& to, const std::string& reason) {
        if (element_.type == to) return;
        warn(fmt::format("read as type \"{}\": {}", to, reason));
        element_.type = to;
    }
    double number(const std::string& name, double fallback) {
        const Property* property = find(name);
        if (!property) return fallback;
        if (const double* value = std::get_if<double>(&property->value)) return *value;
        if (const int64_t* value = std::get_if<int64_t>(&property->value)) return static_cast<double>(*value);
        throw element_.error(*property, "expected a <float>");
    }

    void bsdf() {
        if (element_.type == "diffuse" || element_.type == "roughdiffuse") {
            if (find("reflectance"))
                drop({"diffuse_reflectance"}, "\"reflectance\" holds");
            else
                rename("diffuse_reflectance", "reflectance");
        }
    }

    void texture() {
        if (element_.type == "bitmap") bitmap();
        if (element_.type == "vertexcolors") vertexColors();
        const Property* first = nullptr;
        for (const char* name : {"uoffset", "voffset", "uscale", "vscale"})
            if (const Property* property = find(name); property && !first) first = property;
        if (!first) return;
        Property toUv = *first;
        // The order of the two is that of Mitsuba 3's own upgrade: uv' = scale * (uv + offset).
        const Vec3f offset(static_cast<float>(number("uoffset", 0)), static_cast<float>(number("voffset", 0)),
                           0);
        const Vec3f scale(static_cast<float>(number("uscale", 1)), static_cast<float>(number("vscale", 1)),
                          1);
        try {
            toUv.value = Transform::scale(scale) * Transform::translate(offset);
        } catch (const Error& problem) {
            throw element_.error(*first, problem.what());
        }
        for (const char* name : {"uoffset", "voffset", "uscale", "vscale"}) erase(name);
        element_.named.emplace_back("to_uv", std::move(toUv));
    }

    void bitmap() {
        drop({"max_anisotropy"}, "textures are not filtered anisotropically");
        if (Property* filter = find("filter_type")) {
            std::string* type = std::get_if<std::string>(&filter->value);
            if (type && (*type == "ewa" || *type == "trilinear")) *type = "bilinear";
        }
        if (Property* gamma = find("gamma")) {
            const double value = number("gamma", -1);
            if (value == 1) {  // values are linear already: 3.x says so with `raw`
                gamma->value = true;
                rename("gamma", "raw");
            } else {
                if (value != -1) warn(fmt::format("gamma {} is read as sRGB's transfer curve", value));
                erase("gamma");
            }
        }
    }

    void vertexColors() {
        element_.type = "mesh_attribute";
        Property name;
        name.value = std::string("vertex_color");
        name.location = element_.location;
        element_.named.emplace_back("name", std::move(name));
    }

    void film() {
        for (const char* type : {"ldrfilm", "tiledhdrfilm", "mfilm"})
            if (element_.type == type) changeType("hdrfilm", "films differ only in the file that they wrote");
        drop({"filename", "gamma", "banner", "attach_log", "exposure", "tonemap_method", "key", "burn",
              "digits", "variable", "channel_names"},
             "the output is chosen on the command line");
        drop({"high_quality_edges"}, "the borders of the image are always exact");
    }

    void sampler() {
        changeType("independent", "samples are drawn by the integrator");
        std::vector<std::string> others;
        for (const auto& entry : element_.named)
            if (entry.first != "sample_count" && entry.first != "seed") others.push_back(entry.first);
        drop(others, "samples are drawn by the integrator");
    }

    Element& element_;
    std::vector<std::string>& warnings_;
};

}  // namespace

std::string snakeCase(const std::string& name) {
    std::string result;
    for (size_t i = 0; i < name.size(); ++i) {
        if (i == 0 || !isLower(name[i - 1]) || !isUpper(name[i])) {
            result += name[i];
            continue;
        }
        result += '_';
        result += lower(name[i]);
        while (i + 1 < name.size() && isUpper(name[i + 1])) result += lower(name[++i]);
    }
    return result;
}

void upgradeElement(Element& element, std::vector<std::string>& warnings) {
    Upgrade(element, warnings).run();
}

}  // namespace metrolux::core::mitsuba
