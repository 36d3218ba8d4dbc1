/// What pages promise is tested: the faults of docs/explain/reliability.md by tests that exist, fuzz targets
/// every week.

#include "paths.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace metrolux::core {
namespace {

namespace fs = std::filesystem;
const fs::path kRoot = METROLUX_SOURCE_DIR;

std::string contentOf(const fs::path& file) {
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
}

/// "Suite.Name" of all tests.
std::set<std::string> testNames() {
    static const std::regex pattern(R"(TEST(_F|_P)?\(\s*(\w+),\s*(\w+)\))");
    std::set<std::string> names;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(kRoot / "tests")) {
        if (entry.path().extension() != ".cpp") continue;
        const std::string text = contentOf(entry.path());
        for (std::sregex_iterator match(text.begin(), text.end(), pattern), end; match != end; ++match)
            names.insert((*match)[2].str() + "." + (*match)[3].str());
    }
    return names;
}

/// Cells of the rows of a table below a heading, up to the next heading.
std::vector<std::vector<std::string>> rowsBelow(const std::string& page, const std::string& heading) {
    std::vector<std::vector<std::string>> rows;
    std::istringstream lines(page.substr(page.find("\n" + heading + "\n") + 1));
    std::string line;
    std::getline(lines, line);
    while (std::getline(lines, line) && !line.starts_with("#")) {
        if (!line.starts_with("|")) continue;
        std::vector<std::string> cells;
        std::istringstream rest(line.substr(1));
        for (std::string cell; std::getline(rest, cell, '|');) {
            cell.erase(0, cell.find_first_not_of(' '));
            cell.erase(cell.find_last_not_of(' ') + 1);
            cells.push_back(cell);
        }
        rows.push_back(cells);
    }
    if (rows.size() > 2) rows.erase(rows.begin(), rows.begin() + 2);  // the head
    return rows;
}

TEST(Promises, EveryFaultNamesATestThatExists) {
    const std::string page = contentOf(kRoot / "docs/explain/reliability.md");
    const std::set<std::string> tests = testNames();
    std::set<std::string> codes, used;
    static const std::regex name(R"(`(\w+)\.(\w+)(\*?)`)"), suite(R"(`(\w+)`: )");
    for (const auto& row : rowsBelow(page, "### Tests of the faults")) {
        ASSERT_EQ(row.size(), 2u);
        codes.insert(row[0]);
        int named = 0;
        for (std::sregex_iterator match(row[1].begin(), row[1].end(), name), end; match != end;
             ++match, ++named) {
            const std::string test = (*match)[1].str() + "." + (*match)[2].str();
            const auto found = tests.lower_bound(test);
            const bool exists = (*match)[3].length() > 0 ? found != tests.end() && found->starts_with(test)
                                                         : tests.contains(test);
            EXPECT_TRUE(exists) << row[0] << ": there is no test " << test;
        }
        EXPECT_TRUE(named > 0 || std::regex_search(row[1], suite)) << row[0] << " names no test";
    }
    EXPECT_GT(codes.size(), 20u);
    const auto faults = rowsBelow(page, "## Faults");
    EXPECT_GT(faults.size(), 20u);
    for (const auto& row : faults) {
        ASSERT_EQ(row.size(), 4u) << row.front();
        EXPECT_TRUE(codes.contains(row[3])) << row[0] << ": " << row[3] << " is no test of the table below";
        used.insert(row[3]);
    }
    for (const std::string& code : codes)
        EXPECT_TRUE(used.contains(code)) << code << " is a test of no fault";
}

TEST(Promises, EveryFuzzTargetIsRunEveryWeek) {
    const auto listed = [](const fs::path& file, const std::regex& pattern) {
        const std::string text = contentOf(file);
        std::smatch match;
        std::set<std::string> names;
        if (!std::regex_search(text, match, pattern)) return names;
        static const std::regex word(R"(\w+)");
        const std::string list = match[1];
        for (std::sregex_iterator w(list.begin(), list.end(), word), end; w != end; ++w)
            names.insert(w->str());
        return names;
    };
    const std::set<std::string> targets =
        listed(kRoot / "fuzz/CMakeLists.txt", std::regex(R"(set\(targets ([^)]*)\))"));
    EXPECT_GE(targets.size(), 7u);
    EXPECT_EQ(listed(kRoot / "Makefile", std::regex("FUZZ_TARGETS := (.*)")), targets);
    EXPECT_EQ(listed(kRoot / ".github/workflows/fuzz.yml", std::regex(R"(target: \[([^\]]*)\])")), targets);
    for (const std::string& target : targets) {
        uintmax_t bytes = 0;
        for (const fs::directory_entry& entry : fs::directory_iterator(kRoot / "fuzz/corpus" / target))
            bytes += entry.file_size();
        EXPECT_GT(bytes, 0u) << target;
        EXPECT_LT(bytes, uintmax_t{4} << 20) << target << ": the corpus of a target is kept below 4 MiB";
    }
}

}  // namespace
}  // namespace metrolux::core
