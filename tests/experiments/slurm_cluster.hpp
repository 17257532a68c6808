#pragma once

#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "support/comes_true.hpp"
#include "support/held_port.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/process.hpp"

namespace tactile::test {

/// A cluster of two nodes on loopback, of Slurm's own programs: munged, slurmctld and a slurmd per node. The environment names
/// its configuration, so Slurm's commands of this process and its children use it. It ends with this object.
class SlurmCluster {
 public:
  /// Why a cluster cannot start here; empty if it can.
  static std::string what_lacks() {
    if (::geteuid() != 0) return "only root can start the daemons of Slurm";
    for (const char* program : {"munged", "slurmctld", "slurmd", "sbatch"}) {
      if (run_shell(std::string("PATH=$PATH:/usr/sbin command -v ") + program).exit_code != 0)
        return std::string(program) + " is missing; scripts/setup installs it";
    }
    return "";
  }

  SlurmCluster() {
    std::ofstream(file("munge.key")) << std::string(64, 'k');
    std::filesystem::permissions(file("munge.key"), std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
    std::filesystem::create_directory(file("state"));
    write_configuration();
    ::setenv("SLURM_CONF", file("slurm.conf").c_str(), 1);
    start("/usr/sbin/munged",
          {"--foreground", "--force", "--key-file=" + file("munge.key"), "--socket=" + file("munge.socket"),
           "--pid-file=" + file("munged.pid"), "--log-file=" + file("munged.log"), "--seed-file=" + file("seed")});
    comes_up([&] { return std::filesystem::exists(file("munge.socket")); });
    start("/usr/sbin/slurmctld", {"-D"});
    comes_up([] { return run_shell("scontrol ping").out.find("UP") != std::string::npos; });
    for (const char* node : {"node1", "node2"}) start_node(node);
  }
  ~SlurmCluster() {
    run_shell("scancel --user=root");
    comes_true([] { return run_shell("squeue --noheader || echo no answer").out.empty(); });
    nodes_.clear();
    daemons_.clear();
    ::unsetenv("SLURM_CONF");
  }
  SlurmCluster(const SlurmCluster&) = delete;
  SlurmCluster& operator=(const SlurmCluster&) = delete;

  bool is_up() const {
    return comes_up([] { return run_shell("sinfo --noheader --format=%D --states=idle").out == "2\n"; });
  }
  /// The last message of each daemon.
  std::string why_it_is_down() const {
    return run_shell("tail -q -n 1 '" + file("munged.log") + "' '" + file("log-ctld") + "' '" + file("log-node1") + "' '" +
                     file("log-node2") + "'")
        .out;
  }
  void start_node(const std::string& name) { nodes_.insert_or_assign(name, daemon("/usr/sbin/slurmd", {"-D", "-N", name})); }

  /// As a power cut of the node that runs a task: its daemon and all that runs on it end at once.
  void kill_busy_node() {
    const std::string name = tasks_on("node1").empty() ? "node2" : "node1";
    nodes_.erase(name);
    const std::vector<pid_t> tasks = tasks_on(name);
    for (const pid_t task : tasks) {
      // The program of Slurm that watches the task must not report its end.
      for (pid_t parent = parent_of(task); parent > 1; parent = parent_of(parent)) {
        if (name_of(parent) == "slurmstepd") ::kill(parent, SIGKILL);
      }
    }
    for (const pid_t task : tasks) ::kill(task, SIGKILL);
  }

 private:
  /// Waits less long than other tests: a machine on which a daemon cannot start tests no cluster.
  template <class Condition>
  static bool comes_up(const Condition& holds) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    while (!holds()) {
      if (std::chrono::steady_clock::now() > end) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return true;
  }

  std::string file(const std::string& name) const { return (folder_ / name).string(); }

  void write_configuration() const {
    std::string host = run_shell("hostname -s").out;
    host.pop_back();
    const HeldPort control, first, second;
    std::ofstream(file("slurm.conf")) << "ClusterName=test\nSlurmctldHost=" << host
                                      << "(127.0.0.1)\nSlurmctldPort=" << control.port()
                                      << "\nAuthType=auth/munge\nAuthInfo=socket=" << file("munge.socket")
                                      << "\nSlurmUser=root\nStateSaveLocation=" << file("state")
                                      << "\nSlurmdSpoolDir=" << file("spool-%n") << "\nSlurmctldPidFile=" << file("slurmctld.pid")
                                      << "\nSlurmdPidFile=" << file("slurmd-%n.pid") << "\nSlurmctldLogFile=" << file("log-ctld")
                                      << "\nSlurmdLogFile=" << file("log-%n")
                                      << "\nProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\n"
                                         "JobAcctGatherType=jobacct_gather/none\nAccountingStorageType=accounting_storage/none\n"
                                         "SelectType=select/cons_tres\nSelectTypeParameters=CR_Core\n"
                                         "ReturnToService=2\nKillWait=10\nSlurmdTimeout=6\nMaxArraySize=4\n"
                                         "NodeName=node1 NodeHostname="
                                      << host << " NodeAddr=127.0.0.1 Port=" << first.port()
                                      << " CPUs=2 State=UNKNOWN\nNodeName=node2 NodeHostname=" << host
                                      << " NodeAddr=127.0.0.1 Port=" << second.port()
                                      << " CPUs=2 State=UNKNOWN\nPartitionName=short Nodes=node[1-2] Default=YES State=UP\n";
  }

  std::vector<pid_t> tasks_on(const std::string& node) const {
    std::vector<pid_t> tasks;
    for (const auto& process : std::filesystem::directory_iterator("/proc")) {
      const std::string number = process.path().filename().string();
      if (number.find_first_not_of("0123456789") != std::string::npos) continue;
      const std::string environment = '\0' + text_in_file(process.path() / "environ");
      const auto has = [&](const std::string& variable) { return environment.find('\0' + variable + '\0') != std::string::npos; };
      if (has("SLURMD_NODENAME=" + node) && has("SLURM_CONF=" + file("slurm.conf"))) tasks.push_back(std::stoi(number));
    }
    return tasks;
  }
  static std::string field_of(pid_t process, const std::string& field) {
    std::ifstream status("/proc/" + std::to_string(process) + "/status");
    for (std::string line; std::getline(status, line);) {
      if (line.starts_with(field + ":\t")) return line.substr(field.size() + 2);
    }
    return "0";
  }
  static pid_t parent_of(pid_t process) { return std::stoi(field_of(process, "PPid")); }
  static std::string name_of(pid_t process) { return field_of(process, "Name"); }

  ChildProcess daemon(const std::string& program, const std::vector<std::string>& arguments) {
    return ChildProcess({.program = program, .arguments = arguments, .own_group = true});
  }
  void start(const std::string& program, const std::vector<std::string>& arguments) {
    daemons_.push_back(daemon(program, arguments));
  }

  TemporaryFolder folder_;
  std::vector<ChildProcess> daemons_;
  std::map<std::string, ChildProcess> nodes_;
};

}  // namespace tactile::test
