#include "fuzz.hpp"

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include <unistd.h>

#include <semiexplicit/checkpoint/checkpoints.hpp>
#include <semiexplicit/observers/invariants.hpp>
#include <semiexplicit/steppers/gauss_legendre.hpp>
#include <semiexplicit/systems/product.hpp>

// A checkpoint file: refused with nothing changed, or gone on with. The first byte decides whether the rest
// is the file, or contents that get a sound frame, which random bytes would never have.
namespace {

using namespace semiexplicit;
using Point = PhasePoint<double, 1>;

std::string in_sound_frame(std::string_view contents) { return detail::CheckpointFrame::pack(contents); }

/// Contents behind the settings that this harness expects, so that the numbers are reached.
std::string with_settings(const std::string& settings, std::string_view rest) {
  CheckpointMemory memory;
  std::string text = settings;
  memory(text);
  return memory.bytes() + std::string(rest);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  static const std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("semiexplicit-fuzz-" + std::to_string(getpid()));
  const std::string_view rest(reinterpret_cast<const char*>(data) + 1, size - 1);
  const systems::Product<double> h;
  GaussLegendre stepper(h, {.stages = 2}), untouched = stepper;
  const IntegrationOptions<double> options{.dt = 0.1, .steps = 1000};
  Point z(1, 2);
  Invariants<double, 1> invariants(h);
  Checkpoints checkpoints(path, {.every = 1}, stepper, options, invariants);
  const std::string file = data[0] % 3 == 0   ? std::string(rest)
                           : data[0] % 3 == 1 ? in_sound_frame(rest)
                                              : in_sound_frame(with_settings(checkpoints.settings(), rest));
  std::ofstream(path, std::ios::binary) << file;

  IntegrationReport done;
  bool refused = false;
  try {
    done = checkpoints.resume(z);
  } catch (const std::invalid_argument& refusal) {
    refused = true;
    promise(std::string(refusal.what()).starts_with("checkpoint " + path.string() + ": "),
            "a refusal names the file");
  }
  std::filesystem::remove(path);
  if (refused) {
    promise(z.q()[0] == 1 && z.p()[0] == 2 && !invariants.rows()[0].started,
            "a refusal leaves the state and the observers as they were");
    Point a(1, 2), b = a;
    for (int i = 0; i < 2; ++i) {
      stepper.step(a, 0.1);
      untouched.step(b, 0.1);
    }
    promise(a.vector() == b.vector(), "a refusal leaves the stepper as it was");
  } else {  // whatever the numbers are, a step is taken or reported
    promise(done.steps >= 0, "steps are counted");
    const StepReport report = stepper.step(z, 0.1);
    promise(!report.ok() || z.vector().allFinite(), "a good step gives numbers");
  }
  return 0;
}
