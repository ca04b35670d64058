// SPDX-License-Identifier: Apache-2.0
// The folder of a drive: files that are complete, files that are made again, and two runs at once.
#include <signal.h>

#include <catch2/matchers/catch_matchers_string.hpp>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <functional>
#include <set>

#include "base/hash.hpp"
#include "base/os.hpp"
#include "drive/file_lock.hpp"
#include "drive_support.hpp"
#include "hooked_files.hpp"

using namespace gnosphere;
using namespace gnosphere::test;

namespace {

Json driveWith(const Json& outputs) {
  Json json = smallDrive();
  json["outputs"] = outputs;
  return json;
}

/// The small drive with these outputs, made in the folder `whole`, which stays as it is, and in the folder `out`.
struct MadeTwice {
  explicit MadeTwice(const Json& outputs) : read(folder.read(driveWith(outputs))) {
    for (const char* name : {"whole", "out"}) drive::run(read, optionsFor(folder / name));
  }

  DriveFolder folder;
  drive::Drive read;
};

}  // namespace

TEST_CASE("a frame that is half there is made again, and with verify one whose bytes have changed") {
  const MadeTwice made({{{"format", "kitti"}}, {{"format", "mcap"}}});
  const auto& [folder, drive] = made;
  const std::string points = "kitti/sequences/00/velodyne/00000";
  fs::resize_file(folder / "out" / (points + "3.bin"), 100);
  fs::remove(folder / "out" / (points + "5.bin"));
  fs::remove(folder / "out/manifest/frames/000007.json");
  CHECK(drive::run(drive, optionsFor(folder / "out")).kept == 7);
  checkSameFiles(folder / "whole", folder / "out");

  std::string bytes = folder.get("out/" + points + "4.bin");
  bytes[17] = static_cast<char>(bytes[17] ^ 1);
  put(folder / "out" / (points + "4.bin"), bytes);
  CHECK(drive::run(drive, optionsFor(folder / "out")).kept == 10);
  drive::RunOptions verify = optionsFor(folder / "out");
  verify.verify = true;
  CHECK(drive::run(drive, verify).kept == 9);
  checkSameFiles(folder / "whole", folder / "out");

  fs::remove(folder / "out/mcap/drive.mcap");  // its chunks are gone, so every frame has to be made again
  CHECK(drive::run(drive, optionsFor(folder / "out")).kept == 0);
  checkSameFiles(folder / "whole", folder / "out");
}

TEST_CASE("a frame is made again if its part of a bag, a trace or a cloud has other bytes") {
  const DriveFolder folder;
  const drive::Drive drive =
      folder.read(driveWith({{{"format", "mcap"}}, {{"format", "osi"}}, {{"format", "las"}, {"one_file", true}}}));
  drive::run(drive, optionsFor(folder / "whole"));
  drive::RunOptions most = optionsFor(folder / "out");
  most.endFrame = 9;
  drive::run(drive, most);
  for (const char* part : {"mcap/chunks/000003", "osi/parts/top-000004", "las/parts/top-000005"}) {
    std::string bytes = folder.get("out/" + std::string(part));
    bytes[bytes.size() / 2] ^= 1;
    put(folder / "out" / part, bytes);
  }
  const drive::RunReport report = drive::run(drive, optionsFor(folder / "out"));
  CHECK(report.finished);
  CHECK(report.kept == 6);
  checkSameFiles(folder / "whole", folder / "out");
}

TEST_CASE("frames whose manifests are damaged are missing for a run that makes others") {
  const DriveFolder folder;
  const drive::Drive drive = folder.read(smallDrive());
  drive::RunOptions most = optionsFor(folder / "out"), last = most;
  most.endFrame = last.firstFrame = 9;
  drive::run(drive, most);
  for (const char* frame : {"000003", "000005"})
    put(folder / "out/manifest/frames" / (frame + std::string(".json")), "7");
  const drive::RunReport report = drive::run(drive, last);
  CHECK(!report.finished);
  CHECK(report.missing == 2);
  CHECK(report.firstMissing == 3);
  const drive::RunReport whole = drive::run(drive, optionsFor(folder / "out"));
  CHECK(whole.finished);
  CHECK(whole.kept == 8);
}

TEST_CASE("a part of a bag that nobody has written as such is refused, with the way out") {
  const DriveFolder folder;
  const drive::Drive drive = folder.read(driveWith({{{"format", "mcap"}}}));
  drive::RunOptions most = optionsFor(folder / "out");
  most.endFrame = 9;
  drive::run(drive, most);
  const fs::path part = folder / "out/mcap/chunks/000003", manifest = folder / "out/manifest/frames/000003.json";
  Json content = Json::parse(bytesOf(manifest));
  // Nothing, zeros, and an index that goes back by its own head, after a chunk without messages.
  const std::string chunk = '\6' + std::string(1, 24) + std::string(7 + 24, '\0');
  for (const std::string& bytes :
       {std::string(), std::string(33, '\0'), chunk + "\7\xf7" + std::string(7, '\xff') + "123456"}) {
    put(part, bytes);
    content["files"][0]["bytes"] = bytes.size();
    content["files"][0]["hash"] = hashOf(bytes);
    put(manifest, content.dump());
    CHECK_THROWS_WITH(drive::run(drive, optionsFor(folder / "out")),
                      part.string() + ": is no chunk of a bag; remove it, and its frame is made again");
  }
  fs::remove(part);
  CHECK(drive::run(drive, optionsFor(folder / "out")).finished);
}

TEST_CASE("a manifest that is damaged, or that names files outside of the folder, means that its frame is made again") {
  const MadeTwice made({{{"format", "kitti"}}, {{"format", "mcap"}}});
  const auto& [folder, drive] = made;
  const fs::path manifest = folder / "out/manifest/frames/000003.json";
  const std::string sound = bytesOf(manifest);
  const fs::path victim = folder / "victim";
  put(victim, "precious");
  const auto damaged = [&](const std::function<void(Json&)>& change) {
    Json content = Json::parse(sound);
    change(content);
    return content.dump();
  };
  for (const std::string& content :
       {std::string("7"), std::string("{}"), damaged([](Json& j) { j["files"] = 3; }),
        damaged([](Json& j) { j["files"][0] = "x"; }), damaged([](Json& j) { j["files"][0]["path"] = 5; }),
        damaged([](Json& j) { j["files"][0]["bytes"] = -1; }), damaged([](Json& j) { j["files"][0].erase("hash"); }),
        damaged([](Json& j) { j["scans"] = Json::array(); }), damaged([](Json& j) { j["scans"][0]["points"] = "x"; }),
        damaged([](Json& j) {
          j["scans"][0]["boxes"] = {{{"actor", 2},  // the drive has 0 and 1
                                     {"points", 1},
                                     {"visibility", 0.5},
                                     {"position", {0, 0, 0}},
                                     {"orientation", {0, 0, 0, 1}},
                                     {"size", {1, 1, 1}},
                                     {"moving", false}}};
        }),
        damaged([&](Json& j) {
          j["files"][0] = {{"path", victim.string()}, {"bytes", 8}, {"hash", ""}, {"into", "mcap/drive.mcap"}};
        }),
        damaged([&](Json& j) {
          j["files"][0] = {{"path", "../victim"}, {"bytes", 8}, {"hash", ""}, {"into", "mcap/drive.mcap"}};
        })}) {
    INFO(content);
    put(manifest, content);
    drive::RunOptions verify = optionsFor(folder / "out");
    verify.verify = true;
    CHECK_NOTHROW(drive::run(drive, verify));
    CHECK(bytesOf(victim) == "precious");
    CHECK(bytesOf(manifest) == sound);
  }
}

TEST_CASE("files that need every frame are made again if their size, and with verify their bytes, have changed") {
  const MadeTwice made(everyOutput());
  const auto& [folder, drive] = made;
  drive::RunOptions verify = optionsFor(folder / "out");
  verify.verify = true;
  CHECK(drive::run(drive, verify).broken.empty());
  const Json finished = Json::parse(folder.get("out/manifest/finished"));
  std::set<std::string> tables = {"kitti/sequences/00/times.txt", "pcd/top/poses.txt", "nuscenes/v1.0-drive/scene.json",
                                  "objects.json", "classes.json"};
  const std::string bag = "mcap/drive.mcap";
  for (const Json& file : finished["files"]) tables.erase(file["path"].get<std::string>());
  CHECK(tables.empty());

  put(folder / "out/kitti/sequences/00/times.txt", "");
  fs::remove(folder / "out/objects.json");
  const drive::RunReport emptied = drive::run(drive, optionsFor(folder / "out"));
  CHECK(emptied.broken == std::vector<std::string>{"kitti/sequences/00/times.txt", "objects.json"});
  CHECK(emptied.kept == 10);
  CHECK(emptied.finished);
  checkSameFiles(folder / "whole", folder / "out");

  std::string classes = folder.get("out/classes.json");
  classes.replace(classes.find("car"), 3, "cat");
  put(folder / "out/classes.json", classes);
  CHECK(drive::run(drive, optionsFor(folder / "out")).broken.empty());
  CHECK(drive::run(drive, verify).broken == std::vector<std::string>{"classes.json"});
  checkSameFiles(folder / "whole", folder / "out");

  fs::resize_file(folder / "out" / bag, fs::file_size(folder / "out" / bag) / 2);  // its chunks are gone
  const drive::RunReport cut = drive::run(drive, optionsFor(folder / "out"));
  CHECK(cut.broken == std::vector<std::string>{bag});
  CHECK(cut.kept == 0);
  checkSameFiles(folder / "whole", folder / "out");

  for (const char* damaged : {"", "{}", R"({"files": [{"path": "../drive.json", "bytes": 0, "hash": ""}]})"}) {
    put(folder / "out/manifest/finished", damaged);
    CHECK(drive::run(drive, verify).finished);
    checkSameFiles(folder / "whole", folder / "out");
  }
  CHECK(fs::exists(folder / "drive.json"));
}

TEST_CASE("links in the folder of a drive lead nobody out of it") {
  const DriveFolder folder;
  const drive::Drive drive = folder.read(driveWith({{{"format", "kitti"}}, {{"format", "osi"}}}));
  const fs::path out = folder / "out", elsewhere = folder / "elsewhere";
  fs::create_directory(elsewhere);
  put(elsewhere / "key.txt", "precious");
  const auto isUntouched = [&] {
    return bytesOf(elsewhere / "key.txt") == "precious" &&
           std::distance(fs::directory_iterator(elsewhere), fs::directory_iterator()) == 1;
  };
  const auto refusedFor = [&](const std::string& link) {
    CHECK_THROWS_WITH(drive::run(drive, optionsFor(out)), Catch::Matchers::ContainsSubstring(link + ": is a link") &&
                                                              Catch::Matchers::ContainsSubstring("remove the link"));
    CHECK(isUntouched());
  };
  // Each name becomes a link before the first run, so that files would be made behind it.
  for (const char* name : {"manifest", "manifest/frames", "kitti", "kitti/sequences/00", "osi/parts"}) {
    fs::create_directories((out / name).parent_path());
    fs::create_directory_symlink(elsewhere, out / name);
    refusedFor((out / name).string());
    fs::remove_all(out);
  }
  fs::create_directories(out / "manifest");
  fs::create_symlink(elsewhere / "lock", out / "manifest/lock");
  refusedFor((out / "manifest/lock").string());
  fs::remove(out / "manifest/lock");
  fs::create_directory_symlink(folder / "nowhere", out / "kitti");
  refusedFor((out / "kitti").string());
  fs::remove(out / "kitti");

  // A manifest names files behind a link.
  CHECK(drive::run(drive, optionsFor(out)).finished);
  fs::create_directory_symlink("../elsewhere", out / "evil");
  const fs::path finished = out / "manifest/finished", frame = out / "manifest/frames/000003.json";
  const std::string soundFinished = bytesOf(finished), soundFrame = bytesOf(frame);
  put(finished, R"({"files": [{"path": "evil/key.txt", "bytes": 1, "hash": "0"}], "parts": []})");
  refusedFor((out / "evil").string());
  put(finished, soundFinished);
  Json content = Json::parse(soundFrame);
  content["files"][0] = {{"path", "evil/key.txt"}, {"bytes", 8}, {"hash", ""}};
  put(frame, content.dump());
  refusedFor((out / "evil").string());
  content["files"][0]["into"] = "kitti/sequences/00/times.txt";
  put(frame, content.dump());
  fs::remove(finished);
  refusedFor((out / "evil").string());
  put(frame, soundFrame);
  put(finished, soundFinished);

  // Links within the folder stay, and so does one to the whole of it.
  fs::rename(out / "kitti", out / "kept");
  fs::create_directory_symlink("kept", out / "kitti");
  fs::create_directory_symlink(out, folder / "linked");
  fs::remove(out / "kept/sequences/00/times.txt");
  const drive::RunReport report = drive::run(drive, optionsFor(folder / "linked"));
  CHECK(report.broken.size() == 1);
  CHECK(fs::exists(out / "kept/sequences/00/times.txt"));
}

TEST_CASE("a run that ends after another one has finished the same drive leaves no parts behind") {
  const DriveFolder folder;
  const drive::Drive drive = folder.read(driveWith({{{"format", "mcap"}}, {{"format", "osi"}}}));
  drive::run(drive, optionsFor(folder / "whole"));
  drive::RunOptions options = optionsFor(folder / "out");
  const std::string other = "'" GNOSPHERE_BINARY "' drive '" + (folder / "drive.json").string() + "' -o '" +
                            (folder / "out").string() + "' --device reference >'" + (folder / "log").string() + "'";
  int others = 0;
  options.progress = [&](uint64_t done, uint64_t) {
    if (done == 3) others += std::system(other.c_str()) == 0;
  };
  CHECK(drive::run(drive, options).finished);
  CHECK(others == 1);
  checkSameFiles(folder / "whole", folder / "out");
  CHECK_FALSE(fs::exists(folder / "out/mcap/chunks"));
  CHECK_FALSE(fs::exists(folder / "out/osi/parts"));
}

TEST_CASE("a finished drive has no files of processes that were killed on other machines a day ago") {
  const DriveFolder folder;
  const drive::Drive drive = folder.read(driveWith({{{"format", "pcd"}}}));
  const fs::path manifest = folder / "out/manifest";
  const auto left = [&](const std::string& name, int hours) {
    const fs::path parts = manifest / ("parts-" + name), lock = manifest / ("parts-" + name + ".lock");
    fs::create_directories(parts);
    put(parts / "file", "half a file");
    put(lock, "");
    for (const fs::path& made : {parts, lock})
      fs::last_write_time(made, fs::file_time_type::clock::now() - std::chrono::hours(hours));
    return lock;
  };
  left("elsewhere-1-2", 25);
  left("elsewhere-3-4", 23);
  const drive::FileLock atWork(left("elsewhere-5-6", 50), drive::FileLock::If::free);
  const auto parts = [&] {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(manifest))
      if (const std::string name = entry.path().filename().string(); name.starts_with("parts-")) names.insert(name);
    return names;
  };
  drive::RunOptions options = optionsFor(folder / "out");
  options.endFrame = 5;
  drive::run(drive, options);
  CHECK(parts().size() == 6);  // the drive is not finished
  CHECK(drive::run(drive, optionsFor(folder / "out")).finished);
  const std::set<std::string> kept = {"parts-elsewhere-3-4", "parts-elsewhere-3-4.lock", "parts-elsewhere-5-6",
                                      "parts-elsewhere-5-6.lock"};
  CHECK(parts() == kept);
  left("elsewhere-3-4", 25);
  CHECK(drive::run(drive, optionsFor(folder / "out")).finished);
  CHECK(parts().size() == 2);
  // The first of the next two files is of another machine, although its name begins with the name of this one.
  left(os::machineName() + "-2-7-8", 1);
  left(os::machineName() + "-7-8", 1);
  CHECK(drive::run(drive, optionsFor(folder / "out")).finished);
  CHECK(parts().size() == 4);
  CHECK(parts().contains("parts-" + os::machineName() + "-2-7-8"));
}

TEST_CASE("a file system without locks is told once, and a signal that comes while a lock is taken is none") {
  const DriveFolder folder;
  const drive::Drive drive = folder.read(driveWith({{{"format", "mcap"}}}));
  const auto warningsOf = [&](const std::string& out, const std::function<int()>& lock) {
    std::vector<std::string> warnings;
    drive::RunOptions options = optionsFor(folder / out);
    options.simulator.warn = [&](const std::string& text) { warnings.push_back(text); };
    beforeLock = lock;
    CHECK(drive::run(drive, options).finished);
    beforeLock = nullptr;
    std::erase_if(warnings, [](const std::string& text) { return text.find("flock") == text.npos; });
    return warnings;
  };
  const std::vector<std::string> told = warningsOf("without", [] { return ENOSYS; });
  REQUIRE(told.size() == 1);
  CHECK_THAT(told[0], Catch::Matchers::StartsWith((folder / "without").string() + ": its file system has no locks"));
  int calls = 0;
  CHECK(warningsOf("out", [&] { return ++calls % 2 ? EINTR : 0; }).empty());
  CHECK(calls >= 4);
  checkSameFiles(folder / "without", folder / "out");
}

TEST_CASE("a folder that a run which has finished removes while another one writes there is made again") {
  const DriveFolder folder;
  const drive::Drive drive = folder.read(driveWith({{{"format", "mcap"}}}));
  drive::run(drive, optionsFor(folder / "whole"));
  const fs::path chunks = folder / "out/mcap/chunks";
  int removed = 0;
  beforeRename = [&](const std::string& to) {
    if (fs::path(to).parent_path() == chunks && removed++ == 0) fs::remove_all(chunks);
    return 0;
  };
  drive::RunReport report;
  CHECK_NOTHROW(report = drive::run(drive, optionsFor(folder / "out")));
  beforeRename = nullptr;
  CHECK(report.finished);
  CHECK(removed > 1);
  checkSameFiles(folder / "whole", folder / "out");
  // A rename that fails although both folders are there is tried once.
  int tries = 0;
  beforeRename = [&](const std::string& to) { return fs::path(to).extension() == ".pcd" && ++tries ? EIO : 0; };
  CHECK_THROWS_WITH(drive::run(folder.read(driveWith({{{"format", "pcd"}}})), optionsFor(folder / "failed")),
                    Catch::Matchers::ContainsSubstring("cannot be written: Input/output error"));
  beforeRename = nullptr;
  CHECK(tries == 1);
}

TEST_CASE("a folder that cannot be made for a table is told with the reason of the system") {
  const DriveFolder folder;
  const drive::Drive drive = folder.read(driveWith({{{"format", "nuscenes"}}}));
  beforeMkdir = [](const std::string& name) { return fs::path(name).filename() == "v1.0-drive" ? EROFS : 0; };
  CHECK_THROWS_WITH(drive::run(drive, optionsFor(folder / "out")),
                    (folder / "out/nuscenes/v1.0-drive").string() + ": cannot be made: Read-only file system");
  beforeMkdir = nullptr;
  CHECK(drive::run(drive, optionsFor(folder / "out")).finished);
}

TEST_CASE("the thread that calls progress takes the signals of the program, which may raise them or start processes") {
  const DriveFolder folder;
  drive::RunOptions options = optionsFor(folder / "out");
  size_t calls = 0, blocking = 0;
  options.progress = [&](uint64_t, uint64_t) {
    sigset_t blocked;
    ::pthread_sigmask(SIG_BLOCK, nullptr, &blocked);
    ++calls;
    blocking += ::sigismember(&blocked, SIGINT) == 1;
  };
  CHECK(drive::run(folder.read(driveWith({{{"format", "pcd"}}})), options).finished);
  CHECK(calls > 0);
  CHECK(blocking == 0);
}
