#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "measurement.hpp"
#include "scene_picture.hpp"
#include "units.hpp"

namespace examples {

/// Which values of a parameter mean something, in words for "'7' is not ...", and as a test.
struct Allowed {
  std::string words = "a number";
  bool (*holds)(double) = [](double) { return true; };
};
inline const Allowed above_zero{"a positive number", [](double x) { return x > 0; }};
inline const Allowed not_negative{"a number from 0 on", [](double x) { return x >= 0; }};
inline const Allowed half_turn{
    "an angle from 0 to 180 deg; a plain number is in radians, so write \"90 deg\"",
    [](double x) { return x >= 0 && x <= std::acos(-1.0) * (1 + 1e-15); }};

/// A number that the user may set: the option --name. `unit` is any unit of its kind ("m/s" for a velocity),
/// or "" for a number; users may write one behind the value.
struct Parameter {
  std::string name, unit, about;
  Allowed allowed{};
};

/// What the user chose, in the units of the preset.
class Choice {
 public:
  std::string preset;
  std::vector<std::string> effects;
  std::map<std::string, double> values;
  bool is_preset = false;  ///< nothing but the preset's own effects, those of an audit included, and values
  UnitSystem units{};
  /// Those that something has asked for; the others would be set in vain.
  std::shared_ptr<std::set<std::string>> used = std::make_shared<std::set<std::string>>();

  bool on(const std::string& effect) const {
    return std::find(effects.begin(), effects.end(), effect) != effects.end();
  }
  /// Are these, and no others, on?
  bool only(const std::vector<std::string>& names) const {
    return effects.size() == names.size() &&
           std::all_of(names.begin(), names.end(), [this](const auto& name) { return on(name); });
  }
  /// Is a field on, alone or with the motion itself?
  bool only_field(const std::string& field) const { return only({field}) || only({"kinetic", field}); }
  /// Are no others than these on?
  bool only_of(const std::vector<std::string>& names) const {
    return std::all_of(effects.begin(), effects.end(), [&](const auto& effect) {
      return std::find(names.begin(), names.end(), effect) != names.end();
    });
  }
  bool has(const std::string& parameter) const { return values.count(parameter) > 0; }
  /// The value of a parameter. Throws std::invalid_argument where neither preset nor user gives one.
  double operator[](const std::string& parameter) const {
    const auto found = values.find(parameter);
    if (found == values.end())
      throw std::invalid_argument("the preset " + preset + " has no value for --" + parameter + "; give one");
    used->insert(parameter);
    return found->second;
  }
};

/// An effect that can be chosen: the parameters that it takes, where it comes from, and how it is made. Name
/// and description are those of the effect, unless given.
template <int Dof>
struct EffectEntry {
  std::vector<std::string> parameters;
  std::string source;
  std::function<AnyEffect<double, Dof>(const Choice&)> make;
  std::string name, about, acts;

  template <class Make, class E = std::invoke_result_t<Make, const Choice&>>
  EffectEntry(std::vector<std::string> takes, std::string from, Make maker, std::string called = E::name,
              std::string does = E::about)
      : parameters(std::move(takes)),
        source(std::move(from)),
        make(maker),
        name(std::move(called)),
        about(std::move(does)),
        acts(MotionEffect<E>     ? "adds a force of its own: not symplectic"
             : CoupledEffect<E>  ? "couples q and p"
             : PositionEffect<E> ? "acts on q"
             : MomentumEffect<E> ? "acts on p"
                                 : "acts on q and on p") {}
};

/// What --accuracy with a unit is about: a direction that turns, as a unit vector f(q, p), so that its error
/// is an angle.
template <int Dof>
struct TurningFigure {
  std::string name;   ///< of the Figure of the measurement
  std::string unit;   ///< that it is given in, "arcsec", in the time `per`
  std::string per;    ///< as "1 century"
  double longest_dt;  ///< with which it can be measured
  std::function<Eigen::VectorXd(const In<double, Eigen::Dynamic>& q, const In<double, Eigen::Dynamic>& p)>
      direction;
};

/// A set-up ready made. Numbers may have units behind them, as on the command line: "1 GMsun", "2 day",
/// "0.1".
template <int Dof>
struct ScenePreset {
  std::string name, about;
  UnitSystem units;
  std::vector<std::string> effects;  ///< that are on
  std::vector<std::string> also{};   ///< that it has values for, too, and that --audit looks at
  std::map<std::string, std::string> values{};
  std::string dt, time;
  std::int64_t samples = 2000;  ///< rows of the files
  std::function<PhasePoint<double, Dof>(const Choice&)> start;
  std::function<Measurement<Dof>(const Choice&)> measure{};  ///< optional
  std::function<TurningFigure<Dof>(const Choice&)>
      figure{};  ///< optional: what an accuracy in an angle means
};

template <int Dof>
struct SceneProgram {
  std::string name, about;
  std::vector<Parameter> parameters{};
  std::vector<EffectEntry<Dof>> effects{};
  std::vector<ScenePreset<Dof>> presets{};  ///< the first one is taken where none is named
  std::function<View<Dof>(const Choice&)> view{};
  /// Adds what is kept beside the energy.
  std::function<void(Invariants<double, Dof>&, const Choice&)> add_invariants{};
  std::function<void(CLI::App&)> add_options{};
  /// Called once the arguments are read, with the preset's name, before anything is made of them; gives the
  /// name to take.
  std::function<std::string(const std::string& preset)> prepare{};
  Compare compare = Compare::positions;  ///< orbits in an audit
  bool one_effect = false;               ///< each is a whole Hamiltonian, and goes with no other
  std::vector<std::string> joint{};      ///< effects that count one another as there
};

}  // namespace examples
