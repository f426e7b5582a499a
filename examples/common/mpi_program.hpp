#pragma once

#include <exception>
#include <iostream>
#include <string>

#include <mpi.h>
#include <CLI/CLI.hpp>

#include "arguments.hpp"
#include "output.hpp"

namespace examples {

/// "1.23 s, 4.56e+07 member-steps a second, 2.34e+07 a second of a processor".
inline std::string throughput(double work, const std::string& unit, double seconds,
                              double processor_seconds) {
  return formatted("%.2f", seconds) + " s, " + formatted("%.2e", work / seconds) + ' ' + unit +
         " a second, " + formatted("%.2e", work / processor_seconds) + " a second of a processor";
}

/// Calls program() on every process. Only the first thread of a process may call MPI there.
template <class Program>
int with_mpi(int argc, char** argv, const Program& program) {
  int provided = MPI_THREAD_SINGLE;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
  const int code = program();
  MPI_Barrier(MPI_COMM_WORLD);  // what the first one says is out before another one's exit code ends all
  MPI_Finalize();
  return code;
}

/// run_program() on every process: what is said of bad arguments, by the parser or check(), and the results,
/// are said by the first one only. What run() throws on one of them ends all, which would wait for it.
template <class Check, class Run>
int run_mpi_program(CLI::App& app, const std::string& name, int rank, int argc, char** argv,
                    const Check& check, const Run& run) {
  if (rank != 0) {
    std::cout.setstate(std::ios::failbit);
    std::cerr.setstate(std::ios::failbit);
  }
  return run_program(app, argc, argv, [&] {
    check();
    std::cerr.clear();
    try {
      return run();
    } catch (const std::exception& error) {
      // In one piece: mpirun mixes what processes write.
      std::cerr << name + ", process " + std::to_string(rank) + ": " + reason(error) + '\n' << std::flush;
      MPI_Abort(MPI_COMM_WORLD, 1);
      return 1;
    }
  });
}

}  // namespace examples
