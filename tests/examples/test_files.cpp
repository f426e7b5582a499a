#include "../../examples/common/finished_blocks.hpp"
#include "../../examples/common/output.hpp"

#include "catch.hpp"

#include <filesystem>
#include <fstream>
#include <locale>
#include <stdexcept>
#include <string>

#if defined(__linux__)
#include <sys/mount.h>
#include <sys/stat.h>
#endif

#include "folder.hpp"
#include "refusal.hpp"

namespace test_files {

// The files of the example programs and the benchmarks: texts, pictures, finished blocks.

namespace {

using namespace examples;
namespace fs = std::filesystem;

}  // namespace

TEST_CASE("A text goes where its link leads, with decimal points, or there is none of it", "[examples]") {
  struct German : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  const Folder folder;
  const fs::path link = folder.path / "link.md", target = folder.path / "target.md";
  fs::create_symlink("target.md", link);
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new German));
  write_whole(link, [](std::ostream& out) { out << 12345.5 << '\n'; });
  std::locale::global(before);
  CHECK(contents(target) == "12345.5\n");
  CHECK(fs::is_symlink(link));
  CHECK_THROWS(write_whole(link, [](std::ostream&) { throw std::runtime_error("mine"); }));
  CHECK(contents(target) == "12345.5\n");
  CHECK(says(complaint([&] { write_whole(folder.path / "no" / "x.md", [](std::ostream&) {}); }),
             "check that the folder exists"));
}

TEST_CASE("A picture goes where its link leads, and a failed one leaves none", "[examples]") {
  const Folder folder;
  const fs::path png = folder.path / "link.png", target = folder.path / "target.png";
  fs::create_symlink("target.png", png);
  draw(png, gnuplot_prologue(png, 100, 100) + "plot x\n", {});
  CHECK(fs::is_symlink(png));
  CHECK(fs::exists(folder.path / "link.gp"));
  CHECK_FALSE(fs::exists(target.string() + ".part"));
  if (!fs::exists(target)) {
    WARN("no gnuplot here");
    return;
  }
  CHECK(contents(target).substr(1, 3) == "PNG");
  CHECK(says(complaint([&] { draw(png, gnuplot_prologue(png, 100, 100) + "plot nonsense(\n", {}); }),
             "gnuplot failed on"));
  CHECK_FALSE(fs::exists(target));  // it would belong to other data
  CHECK_FALSE(fs::exists(target.string() + ".part"));
}

#if defined(__linux__)
TEST_CASE("No picture is drawn of what went to a pipe, for which gnuplot would wait", "[examples]") {
  const Folder folder;
  const fs::path png = folder.path / "data.png", csv = folder.path / "data.csv";
  fs::create_symlink("/dev/stdout", csv);
  draw(png, gnuplot_prologue(png, 100, 100) + "plot '" + csv.string() + "'\n", {csv});
  fs::remove(csv);
  REQUIRE(mkfifo(csv.c_str(), 0600) == 0);
  draw(png, gnuplot_prologue(png, 100, 100) + "plot '" + csv.string() + "'\n", {csv});
  CHECK_FALSE(fs::exists(folder.path / "data.gp"));
  fs::remove(csv);
  std::ofstream(csv) << "1\n";
  REQUIRE(mkfifo((folder.path / "data.gp").c_str(), 0600) == 0);
  draw(png, gnuplot_prologue(png, 100, 100) + "plot '" + csv.string() + "'\n", {csv});
  CHECK_FALSE(fs::exists(png));
}

TEST_CASE("A picture that a full disk cuts short is an error, and is not there", "[examples]") {
  const Folder folder;
  if (mount("none", folder.path.c_str(), "tmpfs", 0, "size=32k") != 0) {
    WARN("no small tmpfs can be mounted here");
    return;
  }
  const fs::path png = folder.path / "large.png";
  std::ofstream(folder.path / "rest") << std::string(20'000, '1');
  const std::string said = complaint([&] {
    draw(png, gnuplot_prologue(png, 2000, 2000) + "plot sin(9*x) with lines, sin(19*x) with points\n", {});
  });
  const bool there = fs::exists(png) || fs::exists(png.string() + ".part"),
             script = fs::exists(folder.path / "large.gp");
  umount(folder.path.c_str());
  CHECK(script);
  CHECK_FALSE(there);
  if (said == accepted)
    WARN("no gnuplot here");
  else
    CHECK(says(said, png.string() + ": cannot be written"));
}
#endif

TEST_CASE("Finished blocks are whole or not there", "[examples]") {
  const Folder folder;
  const FinishedBlocks blocks(folder.path / "sweep", "settings");
  CHECK(says(complaint([&] { blocks.save(3, {1, 2}); }), "check that the folder exists"));
  fs::create_directory(blocks.folder());
  blocks.save(3, {1, 2});
  CHECK(blocks.load(3) == std::vector<double>{1, 2});
  CHECK_FALSE(blocks.load(4));
  CHECK(blocks.count() == 1);
  std::ofstream(blocks.folder() / "3.block.part");  // of a run that was killed
  std::ofstream(blocks.folder() / "of the user");
  blocks.remove();
  CHECK(fs::exists(blocks.folder() / "of the user"));
  fs::remove(blocks.folder() / "of the user");
  blocks.remove();
  CHECK(fs::is_empty(folder.path));
  CHECK_NOTHROW(blocks.remove());
}

TEST_CASE("Finished blocks belong to one run at a time, which may be killed", "[examples]") {
  const Folder folder;
  const FinishedBlocks blocks(folder.path / "sweep", "settings"), others(folder.path / "sweep", "others");
  fs::create_directory(blocks.folder());
  auto lock = blocks.lock();
  CHECK(says(complaint([&] { blocks.lock(); }), "another run has it open"));
  CHECK_NOTHROW(others.lock());
  blocks.remove();
  lock.reset();
  CHECK(fs::is_empty(folder.path));
  std::ofstream(blocks.folder().string() + ".lock.part");  // of a run that was killed
  lock = blocks.lock();
  CHECK(lock != nullptr);
}

}  // namespace test_files
