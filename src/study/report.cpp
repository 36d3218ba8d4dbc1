#include "study/report.h"

#include "base/error.h"
#include "image/atomic_file.h"
#include "study/machine.h"
#include "study/page.h"

#include <algorithm>
#include <cctype>
#include <cmath>

namespace metrolux::core::study {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

Json numberOrNull(double value) { return std::isfinite(value) ? Json(value) : Json(); }

std::string fileName(const std::string& label) {
    std::string name = label;
    for (char& c : name)
        if (!std::isalnum(static_cast<unsigned char>(c)) && c != '.' && c != '_' && c != '-') c = '-';
    return name;
}

Json perMetric(const std::function<Json(size_t)>& value) {
    Json result = Json::object();
    for (size_t i = 0; i < kMetricCount; ++i) result[kMetricKeys[i]] = value(i);
    return result;
}

Json intervalJson(const Interval& interval) {
    return {{"mean", numberOrNull(interval.mean)},
            {"low", numberOrNull(interval.low)},
            {"high", numberOrNull(interval.high)}};
}

Json measurementJson(const Measurement& m) {
    Json result{{"passes", m.passes}, {"seconds", m.seconds}};
    for (size_t i = 0; i < kMetricCount; ++i) result[kMetricKeys[i]] = numberOrNull(m.values[i]);
    return result;
}

Json runJson(const Entrant& entrant, const Run& run) {
    Json points = Json::array();
    for (const Measurement& m : run.measurements) points.push_back(measurementJson(m));
    const bool hasImage = !run.image.pixels.empty();
    const ImageFiles files = runFiles(entrant, run.seed);
    return {{"seed", run.seed},
            {"stop_reason", stopReasonName(run.reason)},
            {"setup_seconds", run.setupSeconds},
            {"non_finite", run.nonFinite},
            {"exr", hasImage ? Json(files.exr) : Json()},
            {"png", hasImage ? Json(files.png) : Json()},
            {"points", points},
            {"integrator_statistics", run.statistics}};
}

Json curveJson(const std::vector<CurvePoint>& curve) {
    Json result = Json::array();
    for (const CurvePoint& point : curve) {
        Json entry{{"passes", point.passes}, {"seconds", point.seconds}};
        for (size_t i = 0; i < kMetricCount; ++i) entry[kMetricKeys[i]] = intervalJson(point.values[i]);
        result.push_back(entry);
    }
    return result;
}

Json rateJson(const Summary& summary, size_t i) {
    const Rate& rate = summary.rates[i];
    if (rate.seeds == 0) return {};
    Json runs = Json::array();
    for (const PowerLaw& fit : summary.fits[i])
        runs.push_back({{"slope", numberOrNull(fit.slope)},
                        {"log_factor", numberOrNull(fit.logFactor)},
                        {"standard_error", numberOrNull(fit.standardError)},
                        {"points", fit.points}});
    return {{"slope", rate.slope},
            {"standard_error", numberOrNull(rate.standardError)},
            {"seeds", rate.seeds},
            {"runs", runs}};
}

Json summaryJson(const Summary& summary) {
    if (summary.runs == 0) return {};
    const CurvePoint& end = summary.curve.back();
    return {{"runs", summary.runs},
            {"passes", end.passes},
            {"seconds", end.seconds},
            {"final", perMetric([&](size_t i) { return intervalJson(summary.final[i]); })},
            {"final_absolute_bias", intervalJson(summary.finalAbsoluteBias)},
            {"rates", perMetric([&](size_t i) { return rateJson(summary, i); })},
            {"curve", curveJson(summary.curve)}};
}

const char* statusOf(const Contribution& contribution, const Plan& plan) {
    if (!contribution.refusal.empty()) return "refused";
    const size_t complete = contribution.completeRuns().size();
    return complete == static_cast<size_t>(plan.seeds) ? "done" : "incomplete";
}

Json entrantJson(const Entrant& entrant, const Contribution& contribution, const Plan& plan) {
    Json runs = Json::array();
    for (const Run& run : contribution.runs) runs.push_back(runJson(entrant, run));
    return {{"label", entrant.label},
            {"integrator", entrant.integrator},
            {"options", entrant.settings},
            {"status", statusOf(contribution, plan)},
            {"refusal", contribution.refusal.empty() ? Json() : Json(contribution.refusal)},
            {"summary", summaryJson(summarize(contribution, plan))},
            {"runs", runs}};
}

Json noiseJson(const ImageDifference& noise) {
    const PerMetric<double> values = metricValues(noise);
    return perMetric([&](size_t i) { return numberOrNull(values[i]); });
}

Json referenceJson(const Reference& reference) {
    const ImageFiles files = referenceFiles();
    Json result{
        {"exr", files.exr}, {"png", files.png}, {"source", reference.file.empty() ? "rendered" : "file"}};
    if (!reference.file.empty()) {
        result["file"] = reference.file;
        return result;
    }
    result["integrator"] = reference.integrator;
    result["seeds"] = reference.seeds;
    result["passes"] = reference.passes;
    result["seconds"] = reference.seconds;
    result["noise"] = noiseJson(*reference.noise);
    return result;
}

Json planJson(const Plan& plan) {
    std::vector<uint64_t> seeds;
    seeds.reserve(static_cast<size_t>(plan.seeds));
    for (int k = 0; k < plan.seeds; ++k) seeds.push_back(plan.firstSeed + static_cast<uint64_t>(k));
    return {{"limit", plan.seconds > 0 ? "seconds" : "passes"},
            {"seconds", plan.seconds > 0 ? Json(plan.seconds) : Json()},
            {"clock", plan.clock == Clock::Wall ? "wall" : "cpu"},
            {"passes", plan.seconds > 0 ? Json() : Json(plan.passes)},
            {"seeds", seeds},
            {"epsilon", plan.epsilon},
            {"confidence", kConfidence},
            {"fit_share", kFitShare},
            {"grid", plan.grid()}};
}

Json winnersJson(const SceneStudy& study, const Plan& plan) {
    const PerMetric<Ranking> rankings = rank(study.contributions);
    return perMetric([&](size_t i) -> Json {
        const Ranking& ranking = rankings[i];
        if (ranking.winner == Ranking::kNone) return {};
        Json tied = Json::array();
        for (size_t e : ranking.tied) tied.push_back(plan.entrants[e].label);
        return {{"entrant", plan.entrants[ranking.winner].label}, {"tied", tied}};
    });
}

void writeImages(const ImageData& image, const ImageFiles& files, const Metadata& metadata,
                 const fs::path& folder) {
    writeExr(folder / files.exr, image, {}, metadata);
    writePng(folder / files.png, image, 0, ToneCurve::Srgb, metadata);
}

std::string cell(const std::string& text, const Ranking& ranking, size_t entrant) {
    if (ranking.winner == entrant) return "**" + text + "**";
    const bool tied = std::find(ranking.tied.begin(), ranking.tied.end(), entrant) != ranking.tied.end();
    return tied ? "~ " + text : text;
}

std::string rateText(const Rate& rate) {
    if (rate.seeds == 0) return "";
    if (!std::isfinite(rate.standardError)) return fmt::format("{:.2f}", rate.slope);
    return fmt::format("{:.2f} ± {:.2f}", rate.slope, rate.standardError);
}

std::string tableRow(const std::string& label, size_t entrant, const Summary& summary,
                     const PerMetric<Ranking>& rankings) {
    if (summary.runs == 0) return fmt::format("| {} | | | | | | | | |\n", label);
    std::string row = fmt::format("| {} |", label);
    for (Metric metric : kMetrics) {
        const size_t i = indexOf(metric);
        const std::string text = metric == Metric::Bias
                                     ? fmt::format("{:.2f} %", 100 * summary.finalAbsoluteBias.mean)
                                     : fmt::format("{:.4g}", summary.final[i].mean);
        row += fmt::format(" {} |", cell(text, rankings[i], entrant));
    }
    const CurvePoint& end = summary.curve.back();
    const size_t relMse = indexOf(Metric::RelMse);
    return row + fmt::format(" {:.4g} | {} | {:.0f} |\n", summary.final[relMse].mean * end.seconds,
                             rateText(summary.rates[relMse]), end.passes);
}

}  // namespace

ImageFiles referenceFiles() { return {"reference.exr", "reference.png"}; }

ImageFiles runFiles(const Entrant& entrant, uint64_t seed) {
    const std::string name = fmt::format("{}-seed{}", fileName(entrant.label), seed);
    return {name + ".exr", name + ".png"};
}

Json studyJson(const SceneStudy& study, const Plan& plan, const Provenance& provenance) {
    const FilmWindow& w = study.window;
    Json entrants = Json::array();
    for (size_t e = 0; e < study.contributions.size(); ++e)
        entrants.push_back(entrantJson(plan.entrants[e], study.contributions[e], plan));
    return {{"format", "metrolux-study"},
            {"format_version", kFormatVersion},
            {"version", provenance.version},
            {"written", timestamp()},
            {"command", provenance.command},
            {"machine", provenance.machine},
            {"scene",
             {{"name", study.name},
              {"file", study.file},
              {"options", provenance.sceneOptions},
              {"window", {{"x", w.x}, {"y", w.y}, {"width", w.width}, {"height", w.height}}},
              {"image", {{"width", w.fullWidth}, {"height", w.fullHeight}}},
              {"warnings", study.warnings}}},
            {"plan", planJson(plan)},
            {"reference", referenceJson(study.reference)},
            {"interrupted", study.interrupted},
            {"entrants", entrants},
            {"winners", winnersJson(study, plan)}};
}

std::string curvesCsv(const SceneStudy& study, const Plan& plan) {
    std::string text = "scene,entrant,seed,complete,passes,seconds";
    for (const char* key : kMetricKeys) text += fmt::format(",{}", key);
    text += "\n";
    for (size_t e = 0; e < study.contributions.size(); ++e)
        for (const Run& run : study.contributions[e].runs)
            for (const Measurement& m : run.measurements) {
                text += fmt::format("{},{},{},{},{},{}", study.name, plan.entrants[e].label, run.seed,
                                    run.complete() ? 1 : 0, m.passes, m.seconds);
                for (double value : m.values) text += fmt::format(",{}", value);
                text += "\n";
            }
    return text;
}

std::string markdownTable(const SceneStudy& study, const Plan& plan) {
    const PerMetric<Ranking> rankings = rank(study.contributions);
    std::string text = fmt::format("| {} |", study.name), rule = "|---|";
    for (Metric metric : kMetrics) {
        const char* title = metric == Metric::Bias ? "\\|bias\\|" : kMetricTitles[indexOf(metric)];
        text += fmt::format(" {} |", title);
        rule += "---|";
    }
    text += " relMSE × s | rate | passes |\n" + rule + "---|---|---|\n";
    for (size_t e = 0; e < study.contributions.size(); ++e)
        text += tableRow(plan.entrants[e].label, e, summarize(study.contributions[e], plan), rankings);
    return text;
}

void writeReference(const SceneStudy& study, const Provenance& provenance, const fs::path& folder) {
    const Reference& reference = study.reference;
    writeImages(reference.image, referenceFiles(),
                {{"Software", "Metrolux " + provenance.version},
                 {"metrolux:scene", study.file},
                 {"metrolux:reference", reference.file.empty() ? "rendered by " + reference.integrator
                                                               : "copy of " + reference.file}},
                folder);
}

void writeRun(const SceneStudy& study, const Plan& plan, size_t entrant, const Run& run,
              const Provenance& provenance, const fs::path& folder) {
    if (run.image.pixels.empty()) return;
    const Measurement& last = run.measurements.back();
    writeImages(run.image, runFiles(plan.entrants[entrant], run.seed),
                {{"Software", "Metrolux " + provenance.version},
                 {"metrolux:scene", study.file},
                 {"metrolux:integrator", plan.entrants[entrant].label},
                 {"metrolux:passes", static_cast<int>(last.passes)},
                 {"metrolux:seconds", last.seconds},
                 {"metrolux:seed", std::to_string(run.seed)}},
                folder);
}

void writeReport(const SceneStudy& study, const Plan& plan, const Provenance& provenance,
                 const fs::path& folder) {
    const Json json = studyJson(study, plan, provenance);
    writeFile(folder / "study.json", json.dump(2) + "\n");
    writeFile(folder / "curves.csv", curvesCsv(study, plan));
    writeFile(folder / "table.md", markdownTable(study, plan));
    writeFile(folder / "index.html", studyPage(json, pageImages(study, plan)));
}

}  // namespace metrolux::core::study
