#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <mpi.h>

namespace examples {

/// The processes of one trajectory, in a row. What they say to each other is said by all of them.
class Ranks {
 public:
  /// Two numbers that a site shows its neighbour.
  struct Site {
    double q = 0, p = 0;
  };
  /// Of the sites beside a block; zero at the ends of the row.
  struct Beside {
    Site left, right;
  };

  Ranks() {
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &size_);
    told_.resize(static_cast<std::size_t>(size_));
  }
  int rank() const { return rank_; }
  int size() const { return size_; }
  bool first() const { return rank_ == 0; }

  /// The sum, with the same bits on every rank: each adds all numbers in the order of the ranks, which
  /// MPI_Allreduce does not promise.
  double sum(double x) const {
    if (size_ == 1) return x;
    MPI_Allgather(&x, 1, MPI_DOUBLE, told_.data(), 1, MPI_DOUBLE, MPI_COMM_WORLD);
    double all = 0;
    for (const double one : told_) all += one;
    return all;
  }
  std::int64_t least(std::int64_t x) const {
    std::int64_t least_of_all = x;
    MPI_Allreduce(&x, &least_of_all, 1, MPI_INT64_T, MPI_MIN, MPI_COMM_WORLD);
    return least_of_all;
  }

  /// Sends the sites at the ends of a block to the neighbours, calls meanwhile(), and gives theirs.
  template <class Meanwhile>
  Beside exchange(const Site& first, const Site& last, const Meanwhile& meanwhile) const {
    const int left = rank_ > 0 ? rank_ - 1 : MPI_PROC_NULL,
              right = rank_ + 1 < size_ ? rank_ + 1 : MPI_PROC_NULL;
    constexpr int to_left = 1, to_right = 2;
    Beside beside;
    MPI_Request requests[4];
    MPI_Irecv(&beside.left, 2, MPI_DOUBLE, left, to_right, MPI_COMM_WORLD, &requests[0]);
    MPI_Irecv(&beside.right, 2, MPI_DOUBLE, right, to_left, MPI_COMM_WORLD, &requests[1]);
    MPI_Isend(&first, 2, MPI_DOUBLE, left, to_left, MPI_COMM_WORLD, &requests[2]);
    MPI_Isend(&last, 2, MPI_DOUBLE, right, to_right, MPI_COMM_WORLD, &requests[3]);
    meanwhile();
    MPI_Waitall(4, requests, MPI_STATUSES_IGNORE);
    return beside;
  }

 private:
  int rank_ = 0, size_ = 1;
  mutable std::vector<double> told_;
};

}  // namespace examples
