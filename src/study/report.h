#pragma once
/// Turns a study of a scene into files.

#include "study/study.h"

#include <filesystem>

namespace metrolux::core::study {

inline constexpr int kFormatVersion = 1;  ///< of study.json; docs/reference/study.md describes it

/// What is the same for all scenes of a study.
struct Provenance {
    std::string version;               ///< of this program
    std::vector<std::string> command;  ///< its words
    nlohmann::json machine;            ///< describeMachine
    nlohmann::json sceneOptions;       ///< what of the scene was replaced: resolution, defines ...
};

/// Names of files in the folder of a scene.
struct ImageFiles {
    std::string exr, png;
};
ImageFiles referenceFiles();
/// Letters, digits, '.', '_' and '-' of the label stay, all else becomes '-'.
ImageFiles runFiles(const Entrant& entrant, uint64_t seed);

/// Everything but the images: the content of study.json.
nlohmann::ordered_json studyJson(const SceneStudy& study, const Plan& plan, const Provenance& provenance);
/// The measurements of all runs, a row each.
std::string curvesCsv(const SceneStudy& study, const Plan& plan);
/// The errors at the end as a table in Markdown, best values bold, those tied with them marked by "~".
std::string markdownTable(const SceneStudy& study, const Plan& plan);

/// Writes EXR and PNG of the reference. Throws Error.
void writeReference(const SceneStudy& study, const Provenance& provenance,
                    const std::filesystem::path& folder);
/// Writes EXR and PNG of a run that has an image. Throws Error.
void writeRun(const SceneStudy& study, const Plan& plan, size_t entrant, const Run& run,
              const Provenance& provenance, const std::filesystem::path& folder);
/// Writes study.json, curves.csv, table.md and index.html. Throws Error.
void writeReport(const SceneStudy& study, const Plan& plan, const Provenance& provenance,
                 const std::filesystem::path& folder);

}  // namespace metrolux::core::study
