#include "catch.hpp"

#if __has_include(<unistd.h>)
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <locale>
#include <stdexcept>
#include <string>
#include <thread>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>
#if defined(__linux__)
#include <sys/mount.h>
#include <sys/sysmacros.h>
#endif

#include <semiexplicit/semiexplicit.hpp>

#include "child.hpp"
#include "folder.hpp"
#include "refusal.hpp"

namespace test_outputs {

// Outputs on disks that are full, behind links, to devices and pipes, of runs that are killed, and of two
// runs at once.

namespace {

using namespace semiexplicit;
namespace fs = std::filesystem;

/// Writes a table of one row.
void write_table(const fs::path& path, double value = 1) {
  CsvWriter writer(path, {"t"});
  writer.row({value});
  writer.commit();
}

/// How many rows there are, below a header and each with its two numbers, n and 1/3; -1 where one is not
/// whole.
std::int64_t whole_rows(const fs::path& path) {
  const std::string text = contents(path);
  if (text.empty() || !text.starts_with("n,third\n") || text.back() != '\n') return -1;
  std::string expected = "n,third\n";
  const auto rows = std::count(text.begin(), text.end(), '\n') - 1;
  for (std::int64_t n = 0; n < rows; ++n) expected += std::to_string(n) + ",0.3333333333333333\n";
  return text == expected ? rows : -1;
}

/// Rows until one cannot be written; how many could.
std::int64_t rows_until_full(CsvWriter& writer, std::string& said) {
  for (std::int64_t n = 0;; ++n) {
    said = complaint([&] { writer.row({static_cast<double>(n), 1.0 / 3}); });
    if (said != accepted || n == 10'000'000) return n;
  }
}

/// Has file descriptor `number` lead to the end of a file.
class Redirected {
 public:
  Redirected(int number, const fs::path& path) : number_(number), saved_(dup(number)) {
    std::fflush(nullptr);
    const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    dup2(file, number);
    close(file);
  }
  ~Redirected() {
    std::fflush(nullptr);
    dup2(saved_, number_);
    close(saved_);
  }
  Redirected(const Redirected&) = delete;
  Redirected& operator=(const Redirected&) = delete;

 private:
  int number_, saved_;
};

unsigned mode_of(const fs::path& path) { return static_cast<unsigned>(fs::status(path).permissions()); }

}  // namespace

TEST_CASE("Rows that are not committed are announced, and nothing else is", "[io]") {
  const Folder folder;
  const fs::path path = folder.path / "table.csv", said = folder.path / "stderr";
  {
    const Redirected to_file(STDERR_FILENO, said);
    CsvWriter writer(path, {"t"});
    writer.row({1});
  }
  CHECK(contents(said) == "semiexplicit: " + path.string() + " was not committed; what was written is in " +
                              path.string() + ".part\n");
  CHECK(contents(path.string() + ".part") == "t\n1\n");
  CHECK_FALSE(fs::exists(path));
  {
    const Redirected to_file(STDERR_FILENO, said);
    write_table(path);
    { CsvWriter without_rows(path, {"t"}); }
    write_durably(path, "whole");
  }
  CHECK(contents(said) == "semiexplicit: " + path.string() +
                              ": an earlier run did not end; its rows are in " + path.string() + ".part.1\n");
  CHECK(contents(path.string() + ".part.1") == "t\n1\n");
  CHECK_FALSE(fs::exists(path.string() + ".part"));

  CsvWriter twice(path, {"t"});
  twice.commit();
  twice.commit();
  CHECK_THROWS_AS(twice.row({1}), std::logic_error);
  CHECK(contents(path) == "t\n");
}

TEST_CASE("No row is lost where a run is killed", "[io]") {
  const Folder folder;
  const fs::path path = folder.path / "table.csv";
  void* const shared =
      mmap(nullptr, sizeof(std::int64_t), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  REQUIRE(shared != MAP_FAILED);
  auto& returned = *static_cast<volatile std::int64_t*>(shared);
  const pid_t child = start_child([&] {
    CsvWriter writer(path, {"n", "third"});
    for (std::int64_t n = 0;; ++n) {
      writer.row({static_cast<double>(n), 1.0 / 3});
      returned = n + 1;
    }
    return 0;
  });
  while (returned < 1000) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  kill(child, SIGKILL);
  CHECK(exit_code(child) == 128 + SIGKILL);
  const std::int64_t rows = whole_rows(path.string() + ".part");
  CHECK(rows >= returned);
  CHECK(rows <= returned + 1);
  munmap(shared, sizeof(std::int64_t));
}

TEST_CASE("Links stay, and what they lead to is replaced", "[io]") {
  const Folder folder, elsewhere;
  const fs::path target = elsewhere.path / "target.csv", link = folder.path / "link.csv",
                 chain = folder.path / "chain.csv";
  fs::create_symlink(target, link);
  fs::create_symlink("link.csv", chain);
  write_table(chain, 1);  // which leads to no file yet
  CHECK(contents(target) == "t\n1\n");
  fs::permissions(target, fs::perms(0640));
  write_table(chain, 2);
  CHECK(contents(target) == "t\n2\n");
  CHECK(mode_of(target) == 0640);
  write_durably(link, "text");
  CHECK(contents(target) == "text");
  CHECK(fs::read_symlink(link) == target);
  CHECK(fs::read_symlink(chain) == "link.csv");
  {
    CsvWriter writer(chain, {"t"});
    writer.row({3});
    CHECK(contents(target.string() + ".part") == "t\n3\n");
    CHECK((mode_of(target.string() + ".part") & 077) <= 040);  // seen by no one else meanwhile
    writer.commit();
  }
  CHECK_FALSE(fs::exists(target.string() + ".part"));

  DurableFile::remove(chain);
  CHECK_FALSE(fs::exists(target));
  CHECK(fs::is_symlink(link));
  fs::remove(link);
  fs::create_symlink("chain.csv", link);
  CHECK(says(complaint([&] { CsvWriter writer(link, {"t"}); }), link.string() + ": the link leads nowhere"));
  fs::remove(link);
  fs::create_symlink(elsewhere.path / "no" / "folder", link);
  CHECK(says(complaint([&] { CsvWriter writer(link, {"t"}); }), "check that the folder exists"));
}

TEST_CASE("Devices and pipes are written to and stay what they are", "[io]") {
  const Folder folder;
  struct stat now;
  fs::path full = "/dev/full";
#if defined(__linux__)  // one of our own where that may be made
  if (mknod((folder.path / "full").c_str(), S_IFCHR | 0666, makedev(1, 7)) == 0) full = folder.path / "full";
#endif
  if (fs::exists(full)) {
    CsvWriter writer(full, {"t"});
    CHECK(says(complaint([&] { writer.row({1}); }), full.string() + ": cannot be written"));
    CHECK(says(complaint([&] { writer.commit(); }), "is the disk full?"));
    CHECK((stat(full.c_str(), &now) == 0 && S_ISCHR(now.st_mode)));
  }

  const fs::path fifo = folder.path / "fifo", got = folder.path / "got";
  REQUIRE(mkfifo(fifo.c_str(), 0600) == 0);
  const pid_t reader = start_child([&] {
    std::ofstream(got) << contents(fifo);
    return 0;
  });
  write_table(fifo);
  CHECK(exit_code(reader) == 0);
  CHECK(contents(got) == "t\n1\n");
  CHECK(fs::is_fifo(fifo));

  int ends[2];
  REQUIRE(socketpair(AF_UNIX, SOCK_STREAM, 0, ends) == 0);
  write_table("/dev/fd/" + std::to_string(ends[0]));
  char text[5] = {};
  CHECK(read(ends[1], text, 4) == 4);
  CHECK(std::string(text) == "t\n1\n");
  close(ends[0]);
  close(ends[1]);
  CHECK(says(complaint([&] { write_table("/dev/fd/" + std::to_string(ends[0])); }), "Bad file descriptor"));

  CHECK(says(complaint([&] { CsvWriter writer(folder.path, {"t"}); }),
             folder.path.string() + ": is a folder; give the name of a file in it"));
  CHECK(says(complaint([&] { CsvWriter writer("", {"t"}); }), "a file to be written has no name"));
  DurableFile::remove(fifo);
  CHECK(fs::is_fifo(fifo));
}

TEST_CASE("The standard output stays one stream where it goes to a file", "[io]") {
  const Folder folder;
  const fs::path out = folder.path / "out", link = folder.path / "link";
  fs::create_symlink("/dev/stdout", link);
  for (const fs::path& name : {link, fs::path("/dev/fd/1"), fs::path("/proc/self/fd/1")}) {
    {
      const Redirected to_file(STDOUT_FILENO, out);
      std::printf("before\n");
      write_table(name);
      std::printf("after\n");
    }
    CHECK(contents(out) == "before\nt\n1\nafter\n");
    CHECK_FALSE(fs::exists(out.string() + ".part"));
  }
  CHECK(fs::read_symlink(link) == "/dev/stdout");
}

#if defined(__linux__)
TEST_CASE("A full disk costs no earlier row and no earlier file", "[io]") {
  const Folder folder;
  if (mount("none", folder.path.c_str(), "tmpfs", 0, "size=64k") != 0) {
    WARN("no small tmpfs can be mounted here");
    return;
  }
  const fs::path path = folder.path / "table.csv";
  std::ofstream(path) << "old";
  std::int64_t rows = 0;
  std::string said, said_of_text;
  {
    CsvWriter writer(path, {"n", "third"});
    rows = rows_until_full(writer, said);
    CHECK(whole_rows(path.string() + ".part") == rows);
    said_of_text = complaint([&] { write_durably(folder.path / "text", std::string(10'000, '1')); });
    CHECK_FALSE(fs::exists(folder.path / "text.part"));
  }
  const std::int64_t rows_left = whole_rows(path.string() + ".part");
  const std::string old = contents(path);
  const bool no_text = !fs::exists(folder.path / "text");
  {  // the first row is none
    fs::remove(path.string() + ".part");
    std::ofstream(folder.path / "rest") << std::string(100'000, '1');
    CsvWriter writer(path, {"n"});
    CHECK(says(complaint([&] { writer.row({1}); }), "is the disk full?"));
    fs::remove(folder.path / "rest");
    CHECK(writer.fresh());
    writer.row({2});  // there is room again
    writer.commit();
  }
  const std::string later = contents(path);
  umount(folder.path.c_str());
  CHECK(rows > 100);
  CHECK(rows_left == rows);
  CHECK(old == "old");
  CHECK(later == "n\n2\n");
  CHECK(no_text);
  for (const std::string& text : {said, said_of_text}) {
    CHECK(says(text, folder.path.string()));
    CHECK(says(text, "is the disk full?"));
  }
}

#endif

TEST_CASE("A limit on the size of files is an error and no death", "[io]") {
  const Folder folder;
  const fs::path path = folder.path / "table.csv";
  std::ofstream(path) << "old";
  const pid_t child = start_child([&] {
    const rlimit limit{10'000, 10'000};
    if (setrlimit(RLIMIT_FSIZE, &limit) != 0) return 1;
    CsvWriter writer(path, {"n", "third"});
    std::string said;
    const std::int64_t rows = rows_until_full(writer, said);
    if (whole_rows(path.string() + ".part") != rows || rows < 100) return 2;
    return says(said, path.string()) && says(said, "is the disk full?") ? 0 : 3;
  });
  CHECK(exit_code(child) == 0);
  CHECK(contents(path) == "old");
}

TEST_CASE("What is printed to a stream that is closed goes to no file", "[io]") {
  const Folder folder;
  const fs::path path = folder.path / "table.csv", text = folder.path / "text";
  const pid_t child = start_child([&] {
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::close(stream);
    DurableFile file(text);
    CsvWriter writer(path, {"n"});
    writer.row({1.0});
    file.write("whole");
    std::fputs("a complaint\n", stderr);
    std::fputs("a table\n", stdout);
    std::fflush(stdout);
    writer.commit();
    file.commit();
    return 0;
  });
  CHECK(exit_code(child) == 0);
  CHECK(contents(path) == "n\n1\n");
  CHECK(contents(text) == "whole");
}

TEST_CASE("What may not be written is said before the run", "[io]") {
  const Folder folder;
  fs::create_directory(folder.path / "closed");
  std::ofstream(folder.path / "closed" / "old.csv") << "old";
  std::ofstream(folder.path / "protected.csv") << "old";
  fs::permissions(folder.path / "protected.csv", fs::perms(0444));
  fs::permissions(folder.path / "closed", fs::perms(0555));
  fs::permissions(folder.path, fs::perms(0777));
  const pid_t child = start_child([&] {
    if (getuid() == 0 && setuid(65534) != 0) return 1;  // whom no permissions hold
    for (const char* name : {"closed/new.csv", "closed/old.csv"}) {
      const std::string said = complaint([&] { CsvWriter writer(folder.path / name, {"t"}); });
      if (!says(said, (folder.path / name).string() + ": ") || !says(said, "writ")) return 2;
    }
    if (!says(complaint([&] { CsvWriter writer(folder.path / "closed/new.csv", {"t"}); }),
              "check that the folder is writable"))
      return 3;
    if (!says(complaint([&] { CsvWriter writer(folder.path / "protected.csv", {"t"}); }),
              "is write-protected; allow writing, or give another name"))
      return 4;
    return 0;
  });
  CHECK(exit_code(child) == 0);
  CHECK(contents(folder.path / "protected.csv") == "old");
  fs::permissions(folder.path / "closed", fs::perms(0755));
  CHECK(says(complaint([&] { CsvWriter writer(folder.path / "no" / "x.csv", {"t"}); }),
             (folder.path / "no" / "x.csv").string() +
                 ": cannot be written (No such file or directory); check that "
                 "the folder exists and is writable"));
  fs::create_symlink("protected.csv", folder.path / "x.csv.part");
  CHECK(says(complaint([&] { CsvWriter writer(folder.path / "x.csv", {"t"}); }),
             "x.csv.part: is in the way; remove it"));
}

TEST_CASE("A second run on the same table is refused while the first lives", "[io]") {
  const Folder folder;
  const fs::path path = folder.path / "table.csv";
  Signal ready;
  const pid_t child = start_child([&] {
    CsvWriter writer(path, {"t"});
    writer.row({1});
    ready.give();
    pause();
    return 0;
  });
  REQUIRE(ready.wait());
  const std::string said = complaint([&] { write_table(path, 2); });
  CHECK(says(said,
             path.string() + ": another run has it open; wait for its end, or give this run another file"));
  CHECK(contents(path.string() + ".part") == "t\n1\n");
  kill(child, SIGKILL);
  exit_code(child);
  write_table(path, 2);
  CHECK(contents(path) == "t\n2\n");
  CHECK(contents(path.string() + ".part.1") == "t\n1\n");  // of the one that was killed

  CsvWriter writer(path, {"t"});  // two of one process
  CHECK(says(complaint([&] { write_table(path, 3); }), "another run has it open"));
  writer.row({4});
  writer.commit();
  write_table(path, 5);  // the first one is done
  CHECK(contents(path) == "t\n5\n");
  CHECK(std::distance(fs::directory_iterator(folder.path), fs::directory_iterator()) == 2);
}

TEST_CASE("Rows that did not come to an end are kept once", "[io]") {
  const Folder folder;
  const fs::path path = folder.path / "table.csv", first = path.string() + ".part.1",
                 second = path.string() + ".part.2";
  const Redirected quiet(STDERR_FILENO, folder.path / "stderr");
  const auto leave = [&](const std::vector<double>& values) {
    CsvWriter writer(path, {"t"});
    for (const double value : values) writer.row({value});
  };
  leave({1, 2});
  leave({1, 2, 3});  // ends beside the first
  leave({1});        // takes its place there
  CHECK(contents(first) == "t\n1\n2\n3\n");
  leave({1, 3});  // is within it
  CHECK_FALSE(fs::exists(second));
  leave({5});
  CHECK(contents(first) == "t\n1\n2\n3\n");
  CHECK(contents(second) == "t\n1\n3\n");
  fs::create_symlink("table.csv.part.1", path.string() + ".part.3");
  leave({6});
  CHECK(contents(path.string() + ".part.4") == "t\n5\n");
  CHECK(contents(path.string() + ".part") == "t\n6\n");
  fs::create_hard_link(path.string() + ".part", path.string() + ".part.5");  // not a second copy
  leave({7});
  CHECK(contents(path.string() + ".part.5") == "t\n6\n");
}

TEST_CASE("A file that has the name of a .part by chance is moved away, and a rest is not", "[io]") {
  const Folder folder;
  const fs::path path = folder.path / "run", part = folder.path / "run.part",
                 away = folder.path / "run.part.1";
  const auto put = [&](const std::string& text) { std::ofstream(part) << text; };
  put("the user's own");
  { const DurableFile unused(path); }
  CHECK(contents(part) == "the user's own");
  write_durably(path, "a state");
  CHECK(contents(path) == "a state");
  CHECK(contents(away) == "the user's own");
  CHECK_FALSE(fs::exists(part));

  for (const char* rest : {"a st", "a state, and more of it", ""}) {  // of what was killed while it wrote
    put(rest);
    write_durably(path, "a state");
    CHECK(contents(path) == "a state");
    CHECK_FALSE(fs::exists(part));
  }
  CHECK_FALSE(fs::exists(folder.path / "run.part.2"));
  put("nothing is written over this");
  DurableFile(path).commit();
  CHECK(contents(path).empty());
  CHECK(contents(folder.path / "run.part.2") == "nothing is written over this");
}

TEST_CASE("An output does not take the name of another one's .part", "[io]") {
  const Folder folder;
  const fs::path path = folder.path / "a.csv", part = folder.path / "a.csv.part", link = folder.path / "link";
  const std::string reason = "names in .part are for files that are being written; give another name";
  fs::create_symlink("a.csv.part", link);
  // Before the other one, while it is written, and by way of a link.
  CHECK(complaint([&] { CsvWriter other(part, {"t"}); }) == part.string() + ": " + reason);
  CsvWriter writer(path, {"t"});
  writer.row({1});
  for (const fs::path& name : {part, link}) {
    CHECK(complaint([&] { CsvWriter other(name, {"t"}); }) == name.string() + ": " + reason);
    CHECK(complaint([&] { write_durably(name, "text"); }) == name.string() + ": " + reason);
    CHECK(complaint([&] { DurableFile::remove(name); }) == name.string() + ": " + reason);
  }
  writer.row({2});
  writer.commit();
  CHECK(contents(path) == "t\n1\n2\n");

  fs::remove(link);
  REQUIRE(mkfifo((folder.path / "pipe.part").c_str(), 0600) == 0);  // which nobody writes to and renames
  DurableFile::remove(folder.path / "pipe.part");
}

TEST_CASE("A file that is moved away or in the way is not taken for ours", "[io]") {
  const Folder folder;
  const fs::path path = folder.path / "table.csv", part = folder.path / "table.csv.part",
                 stderr_file = folder.path / "stderr";
  {
    const Redirected to_file(STDERR_FILENO, stderr_file);
    CsvWriter writer(path, {"t"});
    writer.row({1});
    fs::rename(part, folder.path / "mine");
    std::ofstream(part) << "other";
    CHECK(says(complaint([&] { writer.commit(); }), "was moved or removed"));
    CHECK_FALSE(fs::exists(path));
  }
  CHECK(contents(part) == "other");
  CHECK(contents(stderr_file).empty());  // the rows are not there
  fs::remove(part);
  CsvWriter writer(path, {"t"});
  writer.row({1});
  fs::create_symlink("mine", path);
  CHECK(says(complaint([&] { writer.commit(); }), "something else has taken this name"));
  CHECK(contents(folder.path / "mine") == "t\n1\n");
}

TEST_CASE("What is kept for a name that something else has taken is where the message says", "[io]") {
  const Folder folder;
  const fs::path path = folder.path / "table.csv", part = folder.path / "table.csv.part";
  const Redirected to_file(STDERR_FILENO, folder.path / "stderr");
  {
    DurableFile file(path);  // which would be removed
    file.write("all that was measured");
    fs::create_directory(path);
    CHECK(says(complaint([&] { file.commit(); }), "what was written is in " + part.string()));
  }
  CHECK(contents(part) == "all that was measured");
}

TEST_CASE("A trajectory of less than no degrees of freedom is refused", "[io]") {
  const Folder folder;
  const fs::path path = folder.path / "table.csv";
  CHECK(refuses([&] { CsvTrajectory(path, -2); },
                "CsvTrajectory: dof is negative (-2); give that of the state, z.dof()"));
  CHECK(fs::is_empty(folder.path));
}

TEST_CASE("The name of a column that would be two is refused", "[io]") {
  const Folder folder;
  for (const char* name : {"q, p", "a\nb", "\"quoted\""})
    CHECK(refuses(
        [&] {
          CsvWriter(folder.path / "table.csv", {"t", name});
        },
        "the name of column 2 holds a comma, a quote or the end of a line"));
  CHECK(fs::is_empty(folder.path));
}

TEST_CASE("Numbers have a decimal point where the locale has a comma", "[io]") {
  struct German : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  const Folder folder;
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new German));
  const fs::path path = folder.path / "table.csv";
  write_table(path, 12345.5);
  const std::string words = detail::in_words(12345.5, 9), scheme = schemes::blanes_moan4<double>().name;
  std::locale::global(before);
  CHECK(contents(path) == "t\n12345.5\n");
  CHECK(words == "12345.5");
  CHECK(scheme == "blanes_moan4");
}

}  // namespace test_outputs

#endif
