// SPDX-License-Identifier: GPL-3.0-or-later
// What a comparison found, in words and sentences, for terminal and page.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <system_error>

#include "core/capitalised.hpp"
#include "daemon/report/comparison_page.hpp"
#include "ident/model/difference_text.hpp"
#include "ident/model/parameter_name.hpp"
#include "ident/model/parameter_text.hpp"

namespace eha::report {

std::string change_word(const ComparedSubject& subject, bool changed) {
  if (!changed) return "not shown";
  return subject.cannot_tell.empty() ? "yes" : "differs";
}

std::string left_over_word(const ComparedSubject& subject) {
  if (!subject.left_over.changed) return "no";
  return subject.judges_left_over && subject.cannot_tell.empty() ? "yes" : "differs";
}

bool leaves_other(const ComparedSubject& subject) { return subject.left_over.changed && subject.judges_left_over; }

namespace {

constexpr double kNearlyChanged = 0.5;  // of a joint half width

/// What a comparison with the first run can find, the most important first.
enum class Finding : std::uint8_t {
  changed,
  does_not_fit,
  does_not_hold,
  other_input,
  cannot_tell,
  leaves_other,
  alike
};

Finding finding_of(const ComparedSubject& subject) {
  if (subject.unfit) return Finding::does_not_fit;
  if (!subject.cannot_tell.empty()) return subject.has_other_input ? Finding::other_input : Finding::cannot_tell;
  if (subject.change && subject.change->changed) return Finding::changed;
  if (!subject.first_model_holds) return Finding::does_not_hold;
  return leaves_other(subject) ? Finding::leaves_other : Finding::alike;
}

/// "half dead band 0.149 to 0.311 V (+0.162 +- 0.009 V), null -0.207 to -0.392 V (-0.185 +- 0.01 V)", the clearest
/// change first.
std::string changes_text(const ComparedSubject& first, const ComparedSubject& subject) {
  constexpr std::size_t kMostNamed = 3;
  std::vector<const ident::ParameterChange*> changed;
  for (const ident::ParameterChange& p : subject.change->parameters) {
    if (p.changed) changed.push_back(&p);
  }
  const auto size = [](const ident::ParameterChange* p) {
    return p->half_width > 0.0 ? std::abs(p->after - p->before) / p->half_width : 0.0;
  };
  std::stable_sort(changed.begin(), changed.end(), [&](const auto* a, const auto* b) { return size(a) > size(b); });
  std::vector<std::string> texts;
  for (const ident::ParameterChange* p : changed) {
    if (texts.size() == kMostNamed) break;
    const ident::DifferenceText text = ident::difference_text(p->after - p->before, p->half_width);
    const std::string unit = ident::after_number(ident::unit_of(*p, subject.model));
    texts.push_back(fmt::format("{} {} to {}{} ({}{} +- {}{})", ident::shown_name(p->role, p->name),
                                ident::value_text(p->name, p->before, first.model, text.resolution),
                                ident::value_text(p->name, p->after, subject.model, text.resolution), unit,
                                p->after > p->before ? "+" : "", text.difference, text.half_width, unit));
  }
  const std::size_t more = changed.size() - texts.size();
  std::string text = fmt::format("{}{}", fmt::join(texts, ", "), more > 0 ? fmt::format(" and {} more", more) : "");
  for (const ident::ParameterChange& p : subject.change->parameters) {
    if (!p.may_have_changed()) continue;
    text += fmt::format("; perhaps {}, too, {} to {}{}", ident::shown_name(p.role, p.name),
                        ident::value_text(p.name, p.before, first.model, p.of_noise),
                        ident::value_text(p.name, p.after, subject.model, p.of_noise),
                        ident::after_number(ident::unit_of(p, subject.model)));
  }
  return text;
}

/// How to learn whether a parameter changed that follows the map.
std::string perhaps_too(const ident::PlantChange& change) {
  std::vector<std::string> names;
  for (const ident::ParameterChange& p : change.parameters) {
    if (p.may_have_changed()) names.push_back(p.name);
  }
  if (names.empty()) return {};
  return fmt::format(" Whether {} changed, too, the sheets of `eha characterise` before and after tell.",
                     fmt::join(names, " and "));
}

/// Whether the map is all that changed, and the records show a leak, which does that.
bool by_leak(const ComparedSubject& subject) {
  return subject.map_cause == MapCause::leak && ident::is_of_dead_zone_alone(*subject.change);
}

const std::string& unfit_label(const ComparedSubject& first, const ComparedSubject& subject) {
  return subject.unfit->is_first ? first.label : subject.label;
}

}  // namespace

std::string cause_sentence(const ComparedSubject& subject) {
  if (finding_of(subject) != Finding::does_not_hold) return {};
  const auto share = [](const ident::ParameterChange& p) {
    return p.half_width > 0.0 ? std::abs(p.after - p.before) / p.half_width : 0.0;
  };
  std::string text;
  if (subject.change) {
    const auto& all = subject.change->parameters;
    const auto nearest =
        std::max_element(all.begin(), all.end(), [&](const auto& a, const auto& b) { return share(a) < share(b); });
    if (nearest != all.end() && share(*nearest) > kNearlyChanged) {
      text = fmt::format("Nearest to a change is {}, by {}{}, {:.0f} % of what would show. ", nearest->name,
                         ident::rounded_to(nearest->after - nearest->before, nearest->half_width),
                         ident::after_number(ident::unit_of(*nearest, subject.model)), 100.0 * share(*nearest));
    }
  }
  return text +
         (subject.is_tight
              ? "By the valve sheets the rods hardly leak, so that dry friction or the load is another "
                "one: friction takes a part of the gain and bends the edges of the dead band. Move the rod by hand, "
                "and look at seals, guides and load."
              : "Friction, a leak or the load may have changed: `eha characterise` shows a leak as a drift inside the "
                "dead band; without one look at seals, guides and load.");
}

std::string to_do_of(const ComparedSubject& subject) {
  if (!subject.jumps.empty()) {
    return fmt::format(
        "{}: {}. Look at the sensor (mounting, wire, connector) first; then compare again without that place: cut the "
        "record with {}.",
        capitalised(subject.jumps), ident::kMakesAJump, subject.cut_beside_jump);
  }
  switch (finding_of(subject)) {
    case Finding::does_not_fit:
      return "Look at both records: an input that reaches one side only, a rod on its end stop, another signal. `eha "
             "fit` of the record that the model does not fit says what lies in it.";
    case Finding::other_input:
      return "Record both with one experiment whose volts do not depend on the rod, so without [hold] and "
             "[characterise], and compare again; of two valve sheets `eha compare` compares the sheets.";
    case Finding::cannot_tell:
      if (subject.left_over.changed) {
        return "Look at the error over time (-o FILE.html draws it) for a sensor that drifts, slips or freezes; then "
               "record both with one experiment, of one length and about one place, and compare again.";
      }
      return "Record both with one experiment, of one length and about one place, and compare again.";
    case Finding::changed:
      return advice_on({&*subject.change}, subject.map_cause, kUntilKnown) + perhaps_too(*subject.change);
    case Finding::does_not_hold:
      return cause_sentence(subject) + " Fit a model to the new record before you rely on one.";
    case Finding::leaves_other:
      return "The parameters hold. Look for what moves the output besides the input: noise of the sensor, friction, "
             "air, or a map that fits less well.";
    case Finding::alike:
      break;
  }
  if (!subject.drift.empty()) return subject.drift + ".";
  if (!subject.noise.empty()) return capitalised(subject.noise) + ".";
  return subject.first_model_error > 0.0 ? "Nothing: the model of the first record holds on this one."
                                         : "Nothing: no change of a parameter is shown.";
}

std::string outcome(const ComparedSubject& first, const ComparedSubject& subject) {
  switch (finding_of(subject)) {
    case Finding::changed:
      return fmt::format("The plant changed{}: {}{}", by_leak(subject) ? ", as by a leak" : "",
                         changes_text(first, subject), leaves_other(subject) ? "; and what the model leaves over" : "");
    case Finding::does_not_fit:
      return fmt::format("No model that suits the one record suits the other; {} does not fit {}", subject.model.name,
                         unfit_label(first, subject));
    case Finding::does_not_hold:
      return fmt::format(
          "Something changed that no parameter shows{}: the model of {} errs {} times as much on {} as one fitted "
          "there",
          leaves_other(subject) ? ", and what the model leaves over" : "", first.label,
          ident::figure_text(subject.first_model_error / subject.left_over.after), subject.label);
    case Finding::other_input:
      return fmt::format(
          "Not shown whether the plant has changed: {}, and the inputs differ",
          subject.change && subject.change->changed ? "the parameters differ" : "the first model errs more here");
    case Finding::cannot_tell:
      return fmt::format("Not shown whether the plant has changed{}",
                         subject.jumps.empty() ? "" : ": " + subject.jumps);
    case Finding::leaves_other:
      return "The same plant by its parameters, but what the model leaves over changed";
    case Finding::alike:
      break;
  }
  return std::string("The same plant, as far as these records show: no parameter changed, and the first model holds") +
         (subject.drift.empty() ? "" : " beside a drift of the output");
}

std::string outcome_of_all(const std::vector<ComparedSubject>& subjects) {
  const auto worst = std::min_element(subjects.begin() + 1, subjects.end(),
                                      [](const auto& a, const auto& b) { return finding_of(a) < finding_of(b); });
  if (subjects.size() == 2 || is_alike(*worst)) return outcome(subjects.front(), *worst);
  std::vector<const ComparedSubject*> found;
  for (auto one = subjects.begin() + 1; one != subjects.end(); ++one) {
    if (!is_alike(*one)) found.push_back(&*one);
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const auto* a, const auto* b) { return finding_of(*a) < finding_of(*b); });
  constexpr std::size_t kMostNamed = 3;
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < std::min(found.size(), kMostNamed); ++i) {
    texts.push_back(fmt::format("{}: {}", found[i]->label, outcome(subjects.front(), *found[i])));
  }
  if (found.size() > kMostNamed) texts.push_back(fmt::format("{} more differ", found.size() - kMostNamed));
  return fmt::format("{}", fmt::join(texts, "; "));
}

bool is_alike(const ComparedSubject& subject) { return finding_of(subject) == Finding::alike; }

std::string unfit_sentence(const ComparedSubject& first, const ComparedSubject& subject) {
  return fmt::format(
      "{} does not fit {}: {}. Its parameters say nothing of the plant, and no change of them is claimed.",
      subject.model.name, unfit_label(first, subject), subject.unfit->why);
}

std::string left_over_sentence(const ComparedSubject& first, const ComparedSubject& subject) {
  const identify::LeftOver& e = subject.left_over;
  const std::string unit = ident::after_number(subject.model.output_unit);
  return fmt::format("What the model leaves over changed by a factor of {}, from {:.3g}{} rms on {} to {:.3g}{}.",
                     ident::figure_text(e.after / e.before), e.before, unit, first.label, e.after, unit);
}

std::string first_model_sentence(const ComparedSubject& first, const ComparedSubject& subject) {
  const double refit = subject.left_over.after;
  const std::string unit = ident::after_number(subject.model.output_unit);
  return fmt::format(
      "The model of {} errs by {:.3g}{} rms on {}, {} times the {:.3g}{} of the model fitted there: "
      "it {}.",
      first.label, subject.first_model_error, unit, subject.label,
      ident::figure_text(subject.first_model_error / refit), refit, unit, first_model_word(subject));
}

std::string first_model_word(const ComparedSubject& subject) {
  return subject.first_model_holds ? "holds" : "does not hold";
}

std::string tested_sentence(const ident::PlantChange& change, std::span<const ComparedSubject> subjects) {
  std::vector<std::string> names;
  for (const ident::ParameterChange& p : change.parameters) names.push_back(p.name);
  const auto names_none = [&](const auto& is_named) {
    return std::none_of(subjects.begin(), subjects.end(), is_named);
  };
  std::vector<std::string> others;
  if (names_none([](const ComparedSubject& s) { return s.map_cause == MapCause::friction; })) {
    others.emplace_back("friction");
  }
  if (names_none([](const ComparedSubject& s) {
        return s.is_tight || s.map_cause == MapCause::leak || s.map_cause == MapCause::leak_and_valve;
      })) {
    others.emplace_back("leaks");
  }
  if (names_none([](const ComparedSubject& s) { return !s.noise.empty(); })) others.emplace_back("noise");
  std::string as = fmt::format("{}", fmt::join(others, ", "));
  if (const std::size_t last = as.rfind(", "); last != std::string::npos) as.replace(last, 2, " or ");
  return fmt::format(
      "Tested: {}. Not tested: what these do not describe{}{}.",
      names.empty() ? "nothing, as no parameter of both is estimated" : fmt::format("{}", fmt::join(names, ", ")),
      as.empty() ? "" : ", as ", as);
}

std::vector<std::string> titles_of(const std::vector<std::string>& paths) {
  std::vector<std::string> titles;
  std::vector<std::string> longer;
  for (const std::string& path : paths) {
    std::error_code ignored;
    const std::filesystem::path whole = std::filesystem::canonical(path, ignored);
    const std::filesystem::path& known = whole.empty() ? std::filesystem::path(path) : whole;
    const bool is_folder = std::filesystem::is_directory(known, ignored);
    titles.push_back((is_folder ? known.filename() : known.stem()).string());
    std::filesystem::path above = known.parent_path();
    // Models of two runs differ in the run's name, not in "models".
    while (above.filename() == "models" || above.filename() == "rejected") above = above.parent_path();
    longer.push_back(above.filename().string() + "/" + titles.back());
  }
  std::vector<std::string> distinct = titles;
  for (std::size_t i = 0; i < titles.size(); ++i) {
    if (std::count(titles.begin(), titles.end(), titles[i]) > 1) distinct[i] = longer[i];
  }
  return distinct;
}

}  // namespace eha::report
