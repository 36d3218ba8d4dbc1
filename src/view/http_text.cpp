#include "view/http_text.h"

#include <charconv>

namespace metrolux::core::view {

std::string percentDecoded(const std::string& text) {
    std::string result;
    for (size_t i = 0; i < text.size(); ++i) {
        unsigned byte = 0;
        if (text[i] == '%' && i + 2 < text.size()) {
            const char* const end = text.data() + i + 3;
            if (std::from_chars(text.data() + i + 1, end, byte, 16).ptr == end) {
                result += static_cast<char>(byte);
                i += 2;
                continue;
            }
        }
        result += text[i] == '+' ? ' ' : text[i];
    }
    return result;
}

void splitTarget(const std::string& target, std::string& path, std::map<std::string, std::string>& query) {
    const size_t mark = target.find('?');
    path = percentDecoded(target.substr(0, mark));
    query.clear();
    if (mark == std::string::npos) return;
    const std::string all = target.substr(mark + 1);
    for (size_t at = 0; at <= all.size();) {
        const size_t end = std::min(all.find('&', at), all.size());
        const std::string pair = all.substr(at, end - at);
        const size_t equals = pair.find('=');
        if (!pair.empty())
            query.emplace(
                percentDecoded(pair.substr(0, equals)),
                equals == std::string::npos ? std::string() : percentDecoded(pair.substr(equals + 1)));
        at = end + 1;
    }
}

}  // namespace metrolux::core::view
