#include "arguments.hpp"

#include <sstream>

// A command line, an argument a line; each is also read as a number with a unit.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::istringstream in(std::string(reinterpret_cast<const char*>(data), size));
  std::vector<std::string> arguments;
  for (std::string line; std::getline(in, line);) arguments.push_back(line);
  const char* const wanted[] = {"m/s", "T", ""};
  for (std::size_t i = 0; i < arguments.size(); ++i) try {
      const bool positive = i % 2 == 0;
      const double value = examples::read_quantity(arguments[i], wanted[i % 3],
                                                   fuzz::program().presets[i / 3 % 2].units, positive);
      promise(std::isfinite(value) && (!positive || value > 0), "a quantity is a number");
    } catch (const std::invalid_argument& refusal) {
      promise(refusal.what()[0] != 0, "a refusal says something");
    }
  // Files are the subject of another harness.
  std::erase_if(arguments, [](const std::string& a) { return a.starts_with("--c"); });
  fuzz::put_options([&](CLI::App& app) {
    app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));  // CLI11 wants the last first
  });
  return 0;
}
