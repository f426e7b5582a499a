#include "arguments.hpp"

#include <sstream>

// A file of --config: what is wrong with its form or its names is refused with file, line and reason.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  fuzz::put_options([&](CLI::App& app) {
    std::istringstream in(text);
    try {
      app.parse_from_stream(in);
    } catch (const CLI::ConfigError& refusal) {
      const std::string what = refusal.what();
      promise(what.starts_with("configuration:") && what[14] >= '1' && what[14] <= '9',
              "a refusal names file and line");
      throw;
    } catch (const CLI::ParseError& refusal) {
      const auto file = std::dynamic_pointer_cast<examples::ConfigFile>(app.get_config_formatter());
      promise(!file->where(refusal.what()).empty(), "a refused value has a place");
      throw;
    }
  });
  return 0;
}
