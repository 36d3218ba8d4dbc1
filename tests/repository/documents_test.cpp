/// The documents of the repository: lines are short enough to read anywhere, and neither links nor the
/// comments that cite a page lead nowhere.

#include "paths.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace metrolux::core {
namespace {

namespace fs = std::filesystem;

const fs::path kRoot = METROLUX_SOURCE_DIR;
constexpr size_t kLongestLine = 140;

struct Line {
    std::string file;  ///< relative to kRoot
    int number;
    std::string text;
    bool code = false;  ///< in a fenced block of a page
};

std::vector<Line> linesOf(const fs::path& file) {
    std::vector<Line> lines;
    std::ifstream in(file);
    std::string text;
    bool fenced = false;
    for (int number = 1; std::getline(in, text); ++number) {
        const bool fence = text.find("```") == text.find_first_not_of(' ') && !text.empty();
        lines.push_back({fs::relative(file, kRoot).generic_string(), number, text, fenced || fence});
        if (fence) fenced = !fenced;
    }
    return lines;
}

/// All files below the folders and directly in kRoot that `wanted` accepts.
template <class Wanted>
std::vector<fs::path> filesIn(const std::vector<std::string>& folders, Wanted&& wanted) {
    std::vector<fs::path> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(kRoot))
        if (entry.is_regular_file() && wanted(entry.path())) files.push_back(entry.path());
    for (const std::string& folder : folders)
        for (const fs::directory_entry& entry : fs::recursive_directory_iterator(kRoot / folder))
            if (entry.is_regular_file() && wanted(entry.path())) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files;
}

std::vector<fs::path> pages() {
    return filesIn({"docs", "tests", "scenes"}, [](const fs::path& p) { return p.extension() == ".md"; });
}

/// UTF-8 characters.
size_t length(const std::string& text) {
    return size_t(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

/// The name by which GitHub links a heading: letters, digits, hyphens and underscores, in lower case.
std::string anchorOf(std::string heading) {
    heading = std::regex_replace(heading, std::regex(R"(\[([^\]]*)\]\([^)]*\))"), "$1");
    std::string anchor;
    for (const char c : heading) {
        const auto u = static_cast<unsigned char>(c);
        if (u >= 0x80 || std::isalnum(u) || c == '-' || c == '_')
            anchor += char(u < 0x80 ? std::tolower(u) : u);
        else if (c == ' ')
            anchor += '-';
    }
    return anchor;
}

std::set<std::string> anchorsOf(const fs::path& page) {
    static const std::regex heading(R"(^#+ +(.*?) *$)"), explicitAnchor(R"re(<a (?:id|name)="([^"]+)")re");
    std::set<std::string> anchors;
    for (const Line& line : linesOf(page)) {
        std::smatch match;
        if (line.code) continue;
        if (std::regex_match(line.text, match, heading)) {
            const std::string anchor = anchorOf(match[1]);
            if (!anchors.insert(anchor).second)
                for (int i = 1; !anchors.insert(anchor + "-" + std::to_string(i)).second;) ++i;
        }
        if (std::regex_search(line.text, match, explicitAnchor)) anchors.insert(match[1]);
    }
    return anchors;
}

std::vector<std::string> allMatches(const std::string& text, const std::regex& pattern) {
    std::vector<std::string> found;
    for (std::sregex_iterator i(text.begin(), text.end(), pattern), end; i != end; ++i)
        found.push_back((*i)[1]);
    return found;
}

TEST(Documents, LinesAreShort) {
    ASSERT_GT(pages().size(), 10u) << "the pages were not found";
    for (const fs::path& page : pages())
        for (const Line& line : linesOf(page))
            EXPECT_LE(length(line.text), kLongestLine) << line.file << ":" << line.number;
}

TEST(Documents, LinksLeadSomewhere) {
    static const std::regex link(R"(\]\(([^)\s]+)\))"), definition(R"(^\[[^\]]+\]: *(\S+))"),
        attribute(R"re((?:src|href)="([^"]+)")re");
    size_t links = 0;
    for (const fs::path& page : pages())
        for (const Line& line : linesOf(page)) {
            if (line.code) continue;
            std::vector<std::string> targets = allMatches(line.text, link);
            for (const std::regex* other : {&definition, &attribute})
                for (const std::string& target : allMatches(line.text, *other)) targets.push_back(target);
            for (const std::string& target : targets) {
                if (target.find(':') != std::string::npos) continue;  // http:, mailto:
                ++links;
                const size_t hash = target.find('#');
                const std::string name = target.substr(0, hash);
                const fs::path file = name.empty() ? page : page.parent_path() / name;
                if (!fs::exists(file)) {
                    ADD_FAILURE() << line.file << ":" << line.number << ": no file for the link " << target;
                } else if (hash != std::string::npos && !anchorsOf(file).contains(target.substr(hash + 1))) {
                    ADD_FAILURE() << line.file << ":" << line.number << ": no heading for the link "
                                  << target;
                }
            }
        }
    EXPECT_GT(links, 30u);
}

/// [text][name] needs a line "[name]: target".
TEST(Documents, NamedLinksAreDefined) {
    static const std::regex use(R"(\]\[([^\]]+)\])"), definition(R"(^\[([^\]]+)\]: *\S+$)");
    for (const fs::path& page : pages()) {
        const auto lines = linesOf(page);
        std::set<std::string> defined;
        for (const Line& line : lines)
            for (const std::string& name : allMatches(line.text, definition)) defined.insert(name);
        for (const Line& line : lines) {
            if (line.code) continue;
            for (const std::string& name : allMatches(line.text, use))
                EXPECT_TRUE(defined.contains(name))
                    << line.file << ":" << line.number << ": no line [" << name << "]: ...";
        }
    }
}

/// Comments, messages and scripts cite pages by their path from the root, and sections by their number. What
/// is part of an address of another project is no citation.
TEST(Documents, CitedPagesExist) {
    static const std::regex citation(R"((?:^|[^\w/])docs/[\w./-]+\.md(?:,? section \d+)?)");
    const auto files =
        filesIn({"src", "tests", "tools", "bench", "fuzz", "cmake", "scenes", "python"}, [](const fs::path& p) {
            const std::set<std::string> extensions = {".h",   ".cpp", ".in",  ".sh",    ".py",
                                                      ".txt", ".xml", ".yml", ".cmake", ".md"};
            return extensions.contains(p.extension().string()) || p.filename() == "Makefile";
        });
    size_t citations = 0;
    for (const fs::path& file : files)
        for (const Line& line : linesOf(file))
            for (std::sregex_iterator i(line.text.begin(), line.text.end(), citation), end; i != end; ++i) {
                ++citations;
                const std::string text = i->str().substr(i->str().find("docs/"));
                const std::string page = text.substr(0, text.find(".md") + 3);
                if (!fs::exists(kRoot / page)) {
                    ADD_FAILURE() << line.file << ":" << line.number << " cites " << page
                                  << ", which does not exist";
                    continue;
                }
                const size_t section = text.rfind("section ");
                if (section == std::string::npos) continue;
                const std::string heading = "## " + text.substr(section + 8) + ".";
                const auto lines = linesOf(kRoot / page);
                EXPECT_TRUE(std::any_of(lines.begin(), lines.end(),
                                        [&](const Line& l) { return l.text.starts_with(heading); }))
                    << line.file << ":" << line.number << " cites " << text << ", which has no heading \""
                    << heading << " ...\"";
            }
    EXPECT_GT(citations, 20u);
}

/// Text of the first match, which must exist.
std::string found(const fs::path& file, const std::regex& pattern) {
    for (const Line& line : linesOf(file)) {
        std::smatch match;
        if (std::regex_search(line.text, match, pattern)) return match[1];
    }
    ADD_FAILURE() << file << " lacks what is looked for";
    return "";
}

TEST(Documents, VersionsAgree) {
    const fs::path changes = kRoot / "CHANGELOG.md", citation = kRoot / "CITATION.cff";
    EXPECT_EQ(found(citation, std::regex("^version: (.*)")), found(changes, std::regex(R"(^## (\S+) \(\d)")))
        << "the last release";
    EXPECT_EQ(found(citation, std::regex("^date-released: \"(.*)\"")),
              found(changes, std::regex(R"(^## \S+ \((\d[^)]*)\))")));
    const std::string heading = std::string("## ") + METROLUX_TEST_VERSION + " (";
    const auto lines = linesOf(changes);
    EXPECT_TRUE(std::any_of(lines.begin(), lines.end(),
                            [&](const Line& line) { return line.text.starts_with(heading); }))
        << "CHANGELOG.md says nothing of " << METROLUX_TEST_VERSION << ", the version of CMakeLists.txt";
}

TEST(Documents, AnchorsAreThoseOfGitHub) {
    EXPECT_EQ(anchorOf("1. Paths, techniques, counts"), "1-paths-techniques-counts");
    EXPECT_EQ(anchorOf("What `--split` is"), "what---split-is");
    EXPECT_EQ(anchorOf("[Link](x.md) & more"), "link--more");
}

}  // namespace
}  // namespace metrolux::core
