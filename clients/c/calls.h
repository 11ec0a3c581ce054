// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <exception>
#include <string>
#include <string_view>
#include <utility>

#include "clients/c/client_c.h"
#include "proto/ipc/unix_socket.h"
#include "proto/os/message.h"

/// The frame of each function of the C interface: it checks what it is given, keeps exceptions in,
/// and leaves a message.
namespace haptic {

/// Longest message that one_line() makes [bytes], and its end.
inline constexpr size_t kMessageBytes = 4 * kLongestMessage + 1;
/// Longest struct that a caller may have [bytes]: one that is not initialised says more.
inline constexpr uint32_t kLongestStruct = 1u << 16;

/// The base of every handle. Memory and threads of a connection belong to the process that made it.
struct Handle {
  const pid_t pid = getpid();
  std::array<char, kMessageBytes> message{};

  bool is_of_parent() const { return pid != getpid(); }
};

/// A failure with the result that the caller gets.
struct Failure : MessageError {
  Failure(hapticd_result why, std::string_view text) : MessageError(text), result(why) {}
  hapticd_result result;
};
struct BadArgument : Failure {
  explicit BadArgument(std::string_view text) : Failure(HAPTICD_BAD_ARGUMENT, text) {}
};

/// The last failure of this thread.
const char* last_message() noexcept;
/// Keeps the message, in the handle too where there is one.
hapticd_result fail(Handle* handle, hapticd_result result, std::string_view text) noexcept;

/// Calls `work`, whose exceptions end here.
template <typename Work>
hapticd_result attempt(Handle* handle, const Work& work) noexcept {
  try {
    return work();
  } catch (const Failure& failure) {
    return fail(handle, failure.result, failure.what());
  } catch (const HandoutError& error) {
    return fail(handle, HAPTICD_NO_SESSION, error.what());
  } catch (const std::exception& error) {
    return fail(handle, HAPTICD_FAILED, error.what());
  } catch (...) {
    return fail(handle, HAPTICD_FAILED, "an unknown failure");
  }
}

/// Calls work() where the handle may be used.
template <typename Work>
hapticd_result with(Handle* handle, const Work& work) noexcept {
  if (handle == nullptr) return fail(nullptr, HAPTICD_BAD_ARGUMENT, "the handle is NULL");
  if (handle->is_of_parent()) {
    return fail(handle, HAPTICD_BAD_ARGUMENT,
                "a connection does not survive fork(); make a new one");
  }
  return attempt(handle, work);
}

/// A child by fork() has no thread to join: what was the parent's is left alone.
template <typename T>
void close_handle(T* handle) noexcept {
  if (handle != nullptr && !handle->is_of_parent()) delete handle;
}

/// Throws BadArgument where one is NULL.
template <typename... Pointers>
void check_given(Pointers... pointers) {
  if (((pointers == nullptr) || ...)) throw BadArgument("an argument is NULL");
}

/// The size that a caller says its struct has. Throws BadArgument.
template <typename T>
uint32_t size_of_given(const T* given) {
  check_given(given);
  uint32_t size;
  std::memcpy(&size, static_cast<const void*>(given), sizeof size);
  if (size < sizeof size || size > kLongestStruct) {
    throw BadArgument("a struct says that it has " + std::to_string(size) +
                      " bytes; set its size, as it.size = sizeof it");
  }
  return size;
}

/// Copies as much as the caller's struct has room for; what only the caller knows is zero.
template <typename T>
void put(T filled, T* out) {
  const uint32_t size = size_of_given(out);
  filled.size = size;
  auto* bytes = reinterpret_cast<std::byte*>(out);
  const size_t known = std::min<size_t>(size, sizeof filled);
  std::memcpy(bytes, &filled, known);
  std::fill(bytes + known, bytes + size, std::byte{});
}

/// A struct of a caller. Throws BadArgument: it is shorter than the first version, or says what
/// this library does not know.
template <typename T>
T taken(const T* given, size_t least) {
  const uint32_t size = size_of_given(given);
  if (size < least) {
    throw BadArgument("a struct of " + std::to_string(size) + " bytes; it has at least " +
                      std::to_string(least));
  }
  const auto* bytes = reinterpret_cast<const std::byte*>(given);
  T out{};
  const size_t known = std::min<size_t>(size, sizeof out);
  if (std::any_of(bytes + known, bytes + size, [](std::byte b) { return b != std::byte{}; })) {
    throw BadArgument("a struct holds more than this library knows; install a newer one");
  }
  std::memcpy(&out, bytes, known);
  return out;
}

/// The status of a connection that has ended; HAPTICD_OK where it has not.
hapticd_result say_gone(bool is_connected, const std::string& refusal, bool has_ended);

}  // namespace haptic

struct hapticd_session : haptic::Handle {
  explicit hapticd_session(std::string of) : name(std::move(of)) {}
  const std::string name;
  std::string answer;
};
