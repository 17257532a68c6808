#include "tactile/hdf5/read_apart.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <new>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "tactile/hdf5/hdf5_objects.hpp"

namespace tactile::hdf5 {
namespace fs = std::filesystem;
namespace {

constexpr rlim_t least_seconds = 20;
constexpr std::uint64_t bytes_a_second = std::uint64_t{4} << 20;
constexpr rlim_t most_memory = rlim_t{2} << 30;                // in addition to what the process has
constexpr std::size_t enough_memory = std::size_t{128} << 20;  // for HDF5 to read a sound file
constexpr std::uint64_t longest_message = std::uint64_t{1} << 31;
constexpr std::uint64_t read_at_once = std::uint64_t{4} << 20;
constexpr std::uint64_t small_table = std::uint64_t{1} << 20;
constexpr int deepest_group = 16;
constexpr unsigned first_checked_superblock = 2;  // since this version the structure has checksums

enum class Ending : std::uint32_t { none, done, error, damaged };

struct Header {
  Ending ending = Ending::none;
  std::uint32_t kind = 0, number = 0;
  std::uint64_t bytes = 0;
};

bool apart = false;

[[noreturn]] void throw_damaged(const fs::path& file) {
  throw Damaged(file.string() + ": damaged, it cannot be read as HDF5; expected a whole file");
}

void put(int out, const void* from, std::size_t size) {
  const char* bytes = static_cast<const char*>(from);
  while (size > 0) {
    const ssize_t written = ::write(out, bytes, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) ::_exit(1);  // the parent has closed the pipe
    bytes += written;
    size -= static_cast<std::size_t>(written);
  }
}

void put(int out, const Header& header, const void* bytes) {
  put(out, &header, sizeof header);
  put(out, bytes, header.bytes);
}

/// @return  false if there is no more
bool get(int in, void* into, std::size_t size) {
  char* bytes = static_cast<char*>(into);
  while (size > 0) {
    const ssize_t read = ::read(in, bytes, size);
    if (read < 0 && errno == EINTR) continue;
    if (read <= 0) return false;
    bytes += read;
    size -= static_cast<std::size_t>(read);
  }
  return true;
}

void limit_to(auto resource, rlim_t most) {
  rlimit limit{};
  if (::getrlimit(resource, &limit) != 0) return;
  limit.rlim_cur = std::min(limit.rlim_max, most);
  ::setrlimit(resource, &limit);
}

/// Whether a child that wants this much memory gets less. It raises its limit of the address space as far as it may.
bool gets_less_than(rlim_t wanted) {
  rlimit space{}, data{};
  return (::getrlimit(RLIMIT_AS, &space) == 0 && space.rlim_max < wanted) ||
         (::getrlimit(RLIMIT_DATA, &data) == 0 && data.rlim_cur < wanted);
}

/// The address space limit of a child, which starts with that of this process. With a sanitizer it is vast.
rlim_t memory_limit() {
  std::ifstream statm("/proc/self/statm");
  rlim_t pages = 0;
  return statm >> pages ? pages * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE)) + most_memory : RLIM_INFINITY;
}

/// Prepares a process that may crash: it is silent, has limits, ends with its parent, and dumps no core.
void become_expendable(pid_t parent, rlim_t seconds, rlim_t memory) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(1);
  ::prctl(PR_SET_DUMPABLE, 0);
  for (const int number : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL, SIGTRAP, SIGSYS, SIGXCPU, SIGPIPE})
    ::signal(number, SIG_DFL);
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) ::signal(number, SIG_IGN);  // the parent handles them
  sigset_t none;
  sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  const int nothing = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  if (nothing >= 0) {
    ::dup2(nothing, STDOUT_FILENO);
    ::dup2(nothing, STDERR_FILENO);
  }
  limit_to(RLIMIT_CORE, 0);
  limit_to(RLIMIT_CPU, seconds);
  limit_to(RLIMIT_AS, memory);
}

/// HDF5 calls some lacks of memory an error of the file.
bool may_lack_memory() {
  void* memory = ::mmap(nullptr, enough_memory, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (memory == MAP_FAILED) return true;
  ::munmap(memory, enough_memory);
  return false;
}

[[noreturn]] void work_apart(const std::function<void(const Send&)>& work, int out) {
  apart = true;
  const auto end = [out](Ending ending, std::string_view text) {
    put(out, {.ending = ending, .bytes = text.size()}, text.data());
    ::_exit(0);
  };
  try {
    work([out](std::uint32_t kind, std::uint32_t number, std::span<const std::byte> bytes) {
      put(out, {.kind = kind, .number = number, .bytes = bytes.size()}, bytes.data());
    });
    end(Ending::done, "");
  } catch (const Damaged& e) {
    if (!may_lack_memory()) end(Ending::damaged, e.what());
  } catch (const Error& e) {
    end(Ending::error, e.what());
  } catch (...) {
    // For example out of memory, which no sound file causes.
  }
  ::_exit(1);
}

/// The child process and its pipe. The destructor ends the process.
class Child {
 public:
  Child(const fs::path& file, const std::function<void(const Send&)>& work) {
    std::error_code unknown;
    const std::uintmax_t size = fs::file_size(file, unknown);
    const rlim_t seconds = least_seconds + (unknown ? 0 : size / bytes_a_second), memory = memory_limit();
    has_less_memory_ = gets_less_than(memory);
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) throw_not_started(file);
    const pid_t parent = ::getpid();
    pid_ = ::fork();
    if (pid_ == 0) {
      ::close(ends[0]);
      const int out = ::fcntl(ends[1], F_DUPFD_CLOEXEC, STDERR_FILENO + 1);  // in case the parent has no standard streams
      become_expendable(parent, seconds, memory);
      work_apart(work, out);
    }
    const int why = errno;
    ::close(ends[1]);
    in_ = ends[0];
    if (pid_ < 0) {
      ::close(in_);
      errno = why;
      throw_not_started(file);
    }
  }
  ~Child() {
    ::close(in_);
    ::kill(pid_, SIGKILL);
    while (::waitpid(pid_, nullptr, 0) < 0 && errno == EINTR) {
    }
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  int in() const { return in_; }
  /// Whether this process is limited to less memory than a child may need.
  bool has_less_memory() const { return has_less_memory_; }

 private:
  [[noreturn]] static void throw_not_started(const fs::path& file) {
    throw Error(file.string() + ": cannot be checked, no process can be started (" + std::strerror(errno) +
                "); expected room for one more process");
  }
  int in_ = -1;
  pid_t pid_ = -1;
  bool has_less_memory_ = false;
};

/// Visits an open file. @throws Damaged  at the first object that HDF5 cannot read
class FileVisitor {
 public:
  FileVisitor(hid_t file, const fs::path& path) : path_(path) {
    H5F_info2_t info{};
    if (H5Fget_info2(file, &info) < 0) fail(path_.string(), "cannot be read");
    has_checksums_ = info.super.version >= first_checked_superblock;
    visit_group(file, 0);
  }

 private:
  void visit_group(hid_t group, int depth) {
    visit_attributes(group);
    if (depth > deepest_group) throw_damaged(path_);
    H5G_info_t info{};
    if (H5Gget_info(group, &info) < 0) fail(path_.string(), "cannot be read");
    const std::vector<std::string> names = members_of(group);
    if (names.size() != info.nlinks) fail(path_.string(), "cannot be read");
    for (const std::string& name : names) {
      H5L_info_t link{};
      if (H5Lget_info(group, name.c_str(), &link, H5P_DEFAULT) < 0) fail(path_.string(), "cannot be read");
      if (link.type == H5L_TYPE_EXTERNAL && linked_file(group, name).empty()) throw_damaged(path_);
      if (link.type != H5L_TYPE_HARD) continue;
      const Id object(H5Oopen(group, name.c_str(), H5P_DEFAULT), H5Oclose);
      if (object < 0) fail(path_.string(), "cannot be read");
      const H5I_type_t type = H5Iget_type(object);
      if (type == H5I_GROUP) visit_group(object, depth + 1);
      if (type == H5I_DATASET) visit_table(object, path_.string() + ": '" + name + "'");
    }
  }

  void visit_attributes(hid_t object) {
    for (const std::string& name : attributes_of(object, path_.string())) {
      const Id attribute(H5Aopen(object, name.c_str(), H5P_DEFAULT), H5Aclose);
      const Id type(attribute < 0 ? -1 : H5Aget_type(attribute), H5Tclose);
      if (type < 0) fail(path_.string(), "cannot be read");
      switch (H5Tget_class(type)) {
        case H5T_INTEGER:
          read_number(object, name, path_.string());
          break;
        case H5T_STRING:
          read_text_attribute(object, name, path_.string());
          break;
        default:
          break;
      }
    }
  }

  void visit_table(hid_t table, const std::string& where) {
    visit_attributes(table);
    check_filters(table, where);
    check_stored_size(table, where);  // visits the index of its chunks
    const hsize_t in_chunk = std::max<hsize_t>(rows_per_chunk(table, where), 1);
    const Id type(H5Dget_type(table), H5Tclose);
    const H5T_class_t of_class = H5Tget_class(type);
    if (of_class != H5T_INTEGER && of_class != H5T_FLOAT && (of_class != H5T_STRING || H5Tis_variable_str(type) > 0)) return;
    const std::vector<hsize_t> shape = shape_of(table, where);
    std::uint64_t row = H5Tget_size(type);
    for (std::size_t axis = 1; axis < shape.size(); ++axis) row *= shape[axis];  // bounded by check_stored_size
    if (shape[0] == 0 || row == 0 || (has_checksums_ && row * shape[0] > small_table)) return;
    const hsize_t rows = std::min(shape[0], in_chunk * std::max<hsize_t>(1, read_at_once / row / in_chunk));
    std::vector<std::byte> values(rows * row);
    for (hsize_t first = 0; first < shape[0]; first += rows)
      read_rows(table, type, values.data(), first, std::min(rows, shape[0] - first), where);
  }

  const fs::path& path_;
  bool has_checksums_ = false;
};

void walk_through(const fs::path& file) {
  try {
    const Id id = open_file(file, false);
    const FileVisitor walk(id, file);
  } catch (const Damaged&) {
    throw_damaged(file);  // one sentence instead of HDF5's text
  }
}

std::chrono::nanoseconds since_epoch(const timespec& time) {
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

/// Identifies a state of a file.
using FileState = std::tuple<dev_t, ino_t, off_t, std::chrono::nanoseconds, std::chrono::nanoseconds>;

}  // namespace

void read_apart(const fs::path& file, const std::function<void(const Send&)>& work, const Take& take) {
  const Session session;  // no other thread may be inside HDF5 during the fork
  const Child child(file, work);
  std::vector<std::byte> bytes;
  for (Header header; get(child.in(), &header, sizeof header) && header.bytes <= longest_message;) {
    bytes.resize(header.bytes);
    if (!get(child.in(), bytes.data(), bytes.size())) break;
    const std::string text(reinterpret_cast<const char*>(bytes.data()), header.ending == Ending::none ? 0 : bytes.size());
    if (header.ending == Ending::done) return;
    if (header.ending == Ending::error) throw Error(text);
    if (header.ending == Ending::damaged) throw Damaged(text);
    if (take) take(header.kind, header.number, bytes);
  }
  if (child.has_less_memory()) throw std::bad_alloc();  // without which HDF5 may crash
  throw_damaged(file);
}

bool is_apart() { return apart; }

void check_readable(const fs::path& file) {
  const Session session;
  struct stat found {};
  if (::stat(file.c_str(), &found) != 0) return;  // opening it reports the error
  const std::chrono::nanoseconds changed = since_epoch(found.st_mtim);
  const FileState state{found.st_dev, found.st_ino, found.st_size, changed, since_epoch(found.st_ctim)};
  static std::set<FileState> readable;
  if (readable.contains(state)) return;
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  read_apart(file, [&](const Send&) { walk_through(file); });
  // The clock of a file system may be so coarse that a later change has the same time.
  const bool is_settled = now - std::max(changed, since_epoch(found.st_ctim)) > std::chrono::milliseconds(50);
  if (is_settled) readable.insert(state);
}

}  // namespace tactile::hdf5
