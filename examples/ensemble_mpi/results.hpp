#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#ifdef SEMIEXPLICIT_EXAMPLES_HDF5
#include <H5Cpp.h>
#endif

#include "../common/output.hpp"
#include "sweep.hpp"

namespace examples {

/// What came of all members: row i is member i's, the columns are Sweep::columns().
class SweepResults {
 public:
  SweepResults(Sweep sweep, std::vector<double> table) : sweep_(std::move(sweep)), table_(std::move(table)) {}

  std::size_t size() const { return table_.size() / width(); }
  double at(std::size_t member, std::size_t column) const { return table_[member * width() + column]; }

  /// The finite numbers of a column, in rising order.
  std::vector<double> sorted(std::size_t column) const {
    std::vector<double> values;
    for (std::size_t i = 0; i < size(); ++i)
      if (std::isfinite(at(i, column))) values.push_back(at(i, column));
    std::sort(values.begin(), values.end());
    return values;
  }

  /// sweep.h5, or sweep.csv where the program was built without HDF5.
  static std::filesystem::path file_in(const std::filesystem::path& folder) {
#ifdef SEMIEXPLICIT_EXAMPLES_HDF5
    return folder / "sweep.h5";
#else
    return folder / "sweep.csv";
#endif
  }

  /// Writes them beside each other: a dataset a column, and the settings as an attribute, or a CSV file. The
  /// file gets its name when it is whole.
  void write(const std::filesystem::path& path) const {
#ifdef SEMIEXPLICIT_EXAMPLES_HDF5
    std::string image;
    try {
      H5::Exception::dontPrint();
      H5::FileAccPropList in_memory;
      in_memory.setCore(std::size_t{1} << 20, false);
      H5::H5File file(path.string(), H5F_ACC_TRUNC, H5::FileCreatPropList::DEFAULT, in_memory);
      const hsize_t count = size();
      const H5::DataSpace space(1, &count);
      H5::DSetCreatPropList untimed;  // without times two equal runs make two equal files
      H5Pset_obj_track_times(untimed.getId(), false);
      for (std::size_t column = 0; column < width(); ++column) {
        std::vector<double> values(size());
        for (std::size_t i = 0; i < size(); ++i) values[i] = at(i, column);
        file.createDataSet(Sweep::columns()[column], H5::PredType::NATIVE_DOUBLE, space, untimed)
            .write(values.data(), H5::PredType::NATIVE_DOUBLE);
      }
      const std::string words = sweep_.in_words();
      const H5::StrType text(H5::PredType::C_S1, words.size());
      file.createAttribute("settings", text, H5::DataSpace(H5S_SCALAR)).write(text, words);
      file.flush(H5F_SCOPE_GLOBAL);
      image.resize(static_cast<std::size_t>(H5Fget_file_image(file.getId(), nullptr, 0)));
      H5Fget_file_image(file.getId(), image.data(), image.size());
    } catch (const H5::Exception& error) {
      throw std::runtime_error(path.string() + ": cannot be made by HDF5: " + error.getDetailMsg());
    }
    write_durably(path, image);
#else
    CsvWriter csv(path, Sweep::columns());
    for (std::size_t i = 0; i < size(); ++i) csv.row(std::span(table_).subspan(i * width(), width()));
    csv.commit();
#endif
  }

  void print(std::ostream& out) const {
    const std::vector<double> reversibility = sorted(2), energy = sorted(3);
    const auto regular =
        std::lower_bound(reversibility.begin(), reversibility.end(), 1e-8) - reversibility.begin();
    const auto share = [&](std::size_t part) {
      return formatted("%.2f %%", 100 * static_cast<double>(part) / static_cast<double>(size()));
    };
    out << "members: " << size() << ", failed " << size() - energy.size() << " ("
        << share(size() - energy.size()) << ")\n";
    if (energy.empty()) return;
    const auto quantile = [&](double q) {
      const double below = std::ceil(q * static_cast<double>(energy.size()));
      return formatted("%.1e", energy[static_cast<std::size_t>(below) - 1]);
    };
    out << "reversibility error below 1e-8, regular so far: " << share(static_cast<std::size_t>(regular))
        << '\n'
        << "energy error: median " << quantile(0.5) << ", 90 % below " << quantile(0.9) << ", 99 % below "
        << quantile(0.99) << ", worst " << quantile(1) << '\n';
  }

  /// The square of initial places with the reversibility error in colours, and below it the distribution of
  /// both errors. The script holds the data.
  std::string script(const std::filesystem::path& png) const {
    std::ostringstream out;
    out << gnuplot_prologue(png, 1200, 1560) << "set datafile missing 'nan'\n$map << END\n";
    for (std::size_t i = 0; i < size(); ++i)
      out << formatted("%.9g,%.9g,%.2f\n", at(i, 0), at(i, 1), logarithm(at(i, 2)));
    out << "END\n$distribution << END\n";
    constexpr int bins = 100;
    constexpr double low = -18, high = 2;
    std::vector<int> reversibility(bins), energy(bins);
    for (std::size_t i = 0; i < size(); ++i)
      for (const auto& [column, counts] : {std::pair(2, &reversibility), std::pair(3, &energy)})
        if (const double x = logarithm(at(i, std::size_t(column))); std::isfinite(x))
          ++(*counts)[std::size_t(std::clamp((x - low) / (high - low) * bins, 0.0, bins - 1.0))];
    for (int i = 0; i < bins; ++i)
      out << low + (i + 0.5) * (high - low) / bins << ',' << energy[std::size_t(i)] << ','
          << reversibility[std::size_t(i)] << '\n';
    // As dense as the members lie.
    const double point = std::clamp(0.8 * std::sqrt(1e5 / static_cast<double>(size())), 0.3, 4.0),
                 edge = sweep_.extent * (1 + 0.007 * point);  // all of a symbol on the border
    out << "END\nset multiplot title "
        << quoted("Four vortices: three on a triangle, the fourth from each point of the plane") +
               " noenhanced font ',20'\n"
        << "set size ratio -1\nset lmargin at screen 0.09\nset rmargin at screen 0.86\nset "
           "bmargin at screen "
           "0.36\nset tmargin at screen 0.95\n"
        << "set palette defined (-16 '#08306b', -13 '#2171b5', -10 '#9ecae1', -7 '#fee391', -3 '#fe9929', 0 "
           "'#cc4c02', 1 '#662506')\n"
        << "set cbrange [-16:1]\nset cblabel 'reversibility error after t = " << formatted("%g", sweep_.time)
        << "'\nset format cb '10^{%.0f}'\nset xlabel 'x of the fourth vortex'\nset ylabel 'y'\nset key off\n"
        << "set xrange [" << -edge << ':' << edge << "]\nset yrange [" << -edge << ':' << edge
        << "]\nset object 1 rectangle from graph 0,0 to graph 1,1 fillcolor rgb '#404040' behind\n"
        << "$corners << END\n0,1\n-0.8660254,-0.5\n0.8660254,-0.5\nEND\n"
        << "plot $map using 1:2:3 with points pointtype 5 pointsize " << point
        << " linecolor palette, \\\n  $corners using 1:2 with points pointtype 6 pointsize 1.6 linewidth 2 "
           "linecolor rgb 'black'\n"
        << "unset object 1\nset size noratio\nset bmargin at screen 0.06\nset tmargin at screen 0.29\nset "
           "rmargin at screen 0.96\n"
        << "set xrange [" << low << ':' << high
        << "]\nset autoscale y\nset yrange [0:]\nset format x '10^{%.0f}'\nset xlabel 'error'\nset ylabel "
           "'members'\nset key top right\nset style fill solid 0.5 noborder\n"
        << "plot $distribution using 1:2 with boxes linecolor rgb '#0072B2' title 'energy', \\\n"
        << "  $distribution using 1:3 with boxes linecolor rgb '#D55E00' title 'reversibility'\nunset "
           "multiplot\n";
    return out.str();
  }

 private:
  static std::size_t width() { return Sweep::columns().size(); }
  static double logarithm(double x) { return std::log10(std::max(x, 1e-18)); }

  Sweep sweep_;
  std::vector<double> table_;
};

}  // namespace examples
