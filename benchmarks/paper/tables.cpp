#include "tables.hpp"

#include <algorithm>
#include <functional>
#include <sstream>
#include <stdexcept>

#include "common/output.hpp"
#include "methods.hpp"

namespace paper {

namespace {

using examples::formatted;

/// Runs of a cell from states that differ by rounding; one where nothing depends on it.
int roundings(const PublishedTable& table, const Method& method, const TableOptions& options) {
  if (!table.of_convergence() || options.is_short) return 1;
  return table.problem == "nls" && method.family != Family::tao ? 1 : 4;
}

/// Steps after which the short runs' averages have settled.
double short_steps(const PublishedTable& table) {
  return table.problem == "nls" ? (table.dt < 0.005 ? 20'000 : 4000)
                                : (table.problem == "vortices" ? 4000 : 10'000);
}

/// The counts of the long run grow late in it, where the short one does not come.
bool comparable(const PublishedTable& table, const TableOptions& options) {
  return !options.is_short || table.label != "tab:10_vortices_2nd_0.01_2";
}

Experiment experiment(const PublishedTable& table, const std::string& method,
                      const PublishedTable::Column& column, const TableOptions& options, int rounding = 0) {
  const double steps = std::min(table.time / table.dt, options.is_short ? short_steps(table) : 1e300);
  return {.problem = table.problem,
          .method = method,
          .dt = table.dt,
          .time = steps * table.dt,
          .epsilon = column.epsilon,
          .solver = column.solver,
          .as_published = options.as_published,
          .rounding = rounding};
}

/// The results of one cell: the run itself, and those from neighbouring states.
std::vector<Result> cell_results(const PublishedTable& table, const std::string& name,
                                 const PublishedTable::Column& column, const TableOptions& options,
                                 const Results& results) {
  std::vector<Result> list;
  for (int r = 0; r < roundings(table, method(name), options); ++r)
    list.push_back(results.get(experiment(table, name, column, options, r)));
  return list;
}

/// A figure of the table, and how it is printed.
struct Quantity {
  const char* name;
  double Published::*published;
  double Result::*ours;
  const char* format;
  bool relative;  ///< difference in per cent; else the ratio ours to published
};

std::vector<Quantity> quantities(const PublishedTable& table) {
  std::vector<Quantity> list{{"NW_itr", &Published::evaluations, &Result::evaluations, "%.3f", true}};
  if (table.of_convergence()) {
    list.push_back({"Max_Error", &Published::max_error, &Result::max_error, "%.3g", false});
    list.push_back({"Max_Defect", &Published::max_defect, &Result::max_defect, "%.3g", false});
  } else {
    list.push_back({"Time", &Published::seconds, &Result::seconds, "%.3g", false});
  }
  return list;
}

std::string number(double value) { return std::isnan(value) ? "" : formatted("%.5g", value); }

/// The file is whole or not there.
void write_file(const std::filesystem::path& path, const std::string& text) {
  std::filesystem::create_directories(path.parent_path());
  examples::write_whole(path, [&](std::ostream& out) { out << text; });
}

std::string file_name(const PublishedTable& table) { return table.label.substr(table.label.find(':') + 1); }

std::string row_of(const std::vector<std::string>& cells) {
  std::string line = "|";
  for (const std::string& cell : cells) line += ' ' + cell + " |";
  return line + '\n';
}

std::string head_of(const std::vector<std::string>& cells) {
  return row_of(cells) + row_of(std::vector<std::string>(cells.size(), "---"));
}

}  // namespace

std::vector<Experiment> experiments(const PublishedTable& table, const TableOptions& options) {
  std::vector<Experiment> list;
  for (const auto& row : table.rows)
    for (const auto& column : table.columns)
      for (int r = 0; r < roundings(table, method(row.method), options); ++r)
        list.push_back(experiment(table, row.method, column, options, r));
  return list;
}

Verdict write_table(const std::filesystem::path& folder, const PublishedTable& table,
                    const TableOptions& options, const Results& results) {
  Verdict verdict;
  std::ostringstream csv, md;
  csv << "method,solver,epsilon,quantity,published,ours,difference,lowest,highest,status\n";
  md << "# " << table.label << "\n\nProblem: " << table.problem << ", dt = " << table.dt
     << ", T = " << table.time << ". "
     << (options.as_published ? "As published." : "With the library's steps.")
     << " A star: at least one step was taken unconverged.\n\n";
  std::vector<std::string> head{"method", "solver", "ε"};
  for (const Quantity& q : quantities(table)) {
    head.push_back(std::string(q.name) + ", published");
    head.push_back("ours");
    head.push_back(q.relative ? "difference" : "ratio");
    if (table.of_convergence()) head.push_back("over 4 roundings");
  }
  md << head_of(head);

  for (const auto& row : table.rows) {
    const Method& chosen = method(row.method);
    for (std::size_t c = 0; c < table.columns.size(); ++c) {
      // The methods without a solver to choose are printed once a tolerance, Tao's once.
      const auto& column = table.columns[c];
      if (chosen.family == Family::tao && c > 0) continue;
      if (!chosen.solves() && column.solver == "broyden") continue;
      const Published& published = row.cells[c];
      const auto ours = cell_results(table, row.method, column, options, results);
      std::vector<std::string> cells{row.method, chosen.solves() ? column.solver : "",
                                     chosen.family == Family::tao ? "" : formatted("%.0e", column.epsilon)};
      for (const Quantity& q : quantities(table)) {
        const double theirs = published.*q.published, value = ours.front().*q.ours;
        const bool has = !std::isnan(theirs);
        const bool is_count = q.ours == &Result::evaluations;
        const double difference = q.relative ? 100 * (value / theirs - 1) : value / theirs;
        auto [lowest, highest] =
            std::minmax_element(ours.begin(), ours.end(),
                                [&](const Result& a, const Result& b) { return a.*q.ours < b.*q.ours; });
        const bool spread = ours.size() > 1;
        if (!has) {
          cells.insert(cells.end(), table.of_convergence() ? 4 : 3, "");
          continue;
        }
        const bool failed = !ours.front().ok() || std::isnan(value);
        const std::string star_theirs = is_count && published.starred ? "*" : "",
                          star_ours = is_count && ours.front().unconverged > 0 ? "*" : "";
        cells.push_back(formatted("%g", theirs) + star_theirs);
        cells.push_back(failed ? "FAILED at t = " + number(ours.front().t)
                               : formatted(q.format, value) + star_ours);
        cells.push_back(failed ? "" : formatted(q.relative ? "%+.1f %%" : "%.3g", difference));
        if (table.of_convergence())
          cells.push_back(spread ? formatted(q.format, (*lowest).*q.ours) + " to " +
                                       formatted(q.format, (*highest).*q.ours)
                                 : "");
        csv << row.method << ',' << cells[1] << ',' << column.epsilon << ',' << q.name << ',' << theirs << ','
            << number(value) << ',' << number(difference) << ','
            << (spread ? number((*lowest).*q.ours) + ',' + number((*highest).*q.ours) : ",") << ',' << '"'
            << ours.front().status << "\"\n";
        if (is_count && comparable(table, options)) {
          ++verdict.compared;
          // Within the printed digits is as good as within the bound. Short runs average over less.
          const double bound = std::max((options.is_short ? 0.06 : 0.02) * theirs, 0.00501);
          if (failed || !(std::abs(value - theirs) <= bound))
            verdict.exceptions.push_back(table.label + ", " + row.method +
                                         (cells[1].empty() ? "" : ", " + cells[1]) +
                                         ", ε = " + formatted("%.0e", column.epsilon) + ": published " +
                                         formatted("%g", theirs) + ", ours " + formatted("%.3f", value));
        }
      }
      md << row_of(cells);
    }
  }
  write_file(folder / (file_name(table) + ".csv"), csv.str());
  write_file(folder / (file_name(table) + ".md"), md.str());
  return verdict;
}

namespace {

struct TimedProblem {
  const char* title;
  const char* table;  ///< that gives the published times
};

const std::vector<TimedProblem> timed_problems{{"NLS, dt = 1e-3", "tab:Schrodinger"},
                                               {"NLS, dt = 1e-2", "tab:Schrodinger_0.01"},
                                               {"ten vortices", "tab:10_vortices"},
                                               {"ten vortices, disparate", "tab:10_vortices_2nd_0.01"}};

/// Methods by order; the first one is the unit.
const std::vector<std::vector<std::string>> timed_methods{
    {"semiexplicit 2", "Tao 2", "Midpoint", "Midpoint, Newton", "Midpoint, fixed point", "library, Strang"},
    {"semiexplicit-S 4, merged", "Tao 4", "IRK4", "IRK4, Newton", "IRK4, fixed point", "library, Suzuki 4"},
    {"semiexplicit-Y 6, merged", "Tao 6", "IRK6, fixed point", "library, Yoshida 6",
     "library, low defect 6"}};

const PublishedTable& table_called(const std::string& label) {
  const auto& tables = published_tables();
  return *std::find_if(tables.begin(), tables.end(), [&](const auto& t) { return t.label == label; });
}

Experiment timing(const PublishedTable& table, const std::string& method, bool is_short) {
  Experiment e = experiment(table, method, {1e-13, "simplified"}, {.is_short = is_short});
  e.series = true;  // for the energy error
  return e;
}

Experiment untimed(Experiment e, bool series) {
  e.series = series;
  return e;
}

}  // namespace

std::vector<Experiment> timing_experiments(bool is_short) {
  std::vector<Experiment> list;
  for (const auto& problem : timed_problems)
    for (const auto& group : timed_methods)
      for (const std::string& name : group) {
        const Experiment e = timing(table_called(problem.table), name, is_short);
        list.push_back(untimed(e, false));
        list.push_back(untimed(e, true));
      }
  return list;
}

void write_timings(const std::filesystem::path& folder, bool is_short, const Results& results) {
  std::ostringstream md, csv;
  csv << "problem,method,published seconds,published ratio,seconds,ratio,gradients per step,evaluations per "
         "step,energy error\n";
  md << "# Times\n\nε = 1e-13, the simplified Newton iteration. Ratios are to the first method of the "
        "group.\n";
  for (const auto& problem : timed_problems) {
    const PublishedTable& table = table_called(problem.table);
    md << "\n## " << problem.title << "\n\n"
       << head_of({"method", "published, s", "ratio", "ours, s", "ratio", "gradient calls a step",
                   "iterations a step", "energy error"});
    const auto column = static_cast<std::size_t>(
        std::find_if(table.columns.begin(), table.columns.end(),
                     [](const auto& c) { return c.epsilon < 1e-12 && c.solver == "simplified"; }) -
        table.columns.begin());
    const auto published = [&](const std::string& name) {
      for (const auto& row : table.rows)
        if (row.method == name.substr(0, name.find(", merged"))) return row.cells[column].seconds;
      return not_given;
    };
    for (const auto& group : timed_methods)
      for (const std::string& name : group) {
        const Experiment e = timing(table, name, is_short);
        const Result ours = results.get(untimed(e, false)), errors = results.get(e),
                     unit = results.get(untimed(timing(table, group.front(), is_short), false));
        const double theirs = published(name), their_unit = published(group.front());
        const std::string seconds =
            ours.ok() ? formatted("%.3g", ours.seconds) : "FAILED at t = " + number(ours.t);
        md << row_of({name, number(theirs), std::isnan(theirs) ? "" : formatted("%.2f", theirs / their_unit),
                      seconds, ours.ok() ? formatted("%.2f", ours.seconds / unit.seconds) : "",
                      formatted("%.1f", ours.gradients), formatted("%.2f", ours.evaluations),
                      formatted("%.1e", errors.worst.front())});
        csv << '"' << problem.title << "\",\"" << name << "\"," << number(theirs) << ','
            << number(theirs / their_unit) << ',' << number(ours.seconds) << ','
            << number(ours.seconds / unit.seconds) << ',' << number(ours.gradients) << ','
            << number(ours.evaluations) << ',' << errors.worst.front() << '\n';
      }
  }
  write_file(folder / "times.md", md.str());
  write_file(folder / "times.csv", csv.str());
}

}  // namespace paper
