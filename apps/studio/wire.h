// SPDX-License-Identifier: MIT
// Encodes and decodes messages between studio and page. See protocol/messages.json.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include <kibori/base/names.h>
#include <kibori/geometry/vec.h>

namespace kibori::studio {

static_assert(std::endian::native == std::endian::little, "messages are little-endian");

class Writer {
 public:
  Writer() = default;
  explicit Writer(uint8_t kind) : bytes_{kind} {}
  template <class T>
  void put(const T& value) {
    if constexpr (std::is_same_v<T, Vec3>) {
      for (int i = 0; i < 3; i++) put(value[i]);
    } else if constexpr (Named<T>) {
      put(static_cast<uint8_t>(value));
    } else if constexpr (std::is_arithmetic_v<T>) {
      add(&value, sizeof value);
    } else {
      put(static_cast<uint32_t>(value.size()));
      add(value.data(), value.size());
    }
  }
  std::vector<uint8_t> take() { return std::move(bytes_); }

 private:
  void add(const void* from, size_t count) {
    const size_t at = bytes_.size();
    bytes_.resize(at + count);
    if (count) std::memcpy(bytes_.data() + at, from, count);
  }
  std::vector<uint8_t> bytes_;
};

template <class Message>
std::vector<uint8_t> encode(Message message) {
  Writer writer(Message::kKind);
  message.fields([&](auto&... field) { (writer.put(field), ...); });
  return writer.take();
}

// Reads values from received bytes. get() returns false if there are too few bytes, a number is not
// finite, or the value of an enumeration is unknown.
class Reader {
 public:
  Reader(const uint8_t* bytes, size_t count) : at_(bytes), end_(bytes + count) {}
  template <class T>
  bool get(T& value) {
    if constexpr (std::is_same_v<T, Vec3>) {
      return get(value[0]) && get(value[1]) && get(value[2]);
    } else if constexpr (Named<T>) {
      uint8_t place = 0;
      if (!get(place) || place >= names_of(value).size()) return false;
      value = static_cast<T>(place);
      return true;
    } else if constexpr (std::is_arithmetic_v<T>) {
      if (static_cast<size_t>(end_ - at_) < sizeof value) return false;
      std::memcpy(&value, at_, sizeof value);
      at_ += sizeof value;
      if constexpr (std::is_floating_point_v<T>) return std::isfinite(value);
      return true;
    } else {
      uint32_t count = 0;
      if (!get(count) || static_cast<size_t>(end_ - at_) < count) return false;
      value.assign(at_, at_ + count);
      at_ += count;
      return true;
    }
  }
  bool done() const { return at_ == end_; }

 private:
  const uint8_t *at_, *end_;
};

// Decodes one of the messages of a variant. Returns nothing if the kind is unknown, the length is
// wrong, or a field is out of range (in_range).
template <class Messages, size_t kIndex = 0>
std::optional<Messages> decode(const uint8_t* bytes, size_t count) {
  if constexpr (kIndex == std::variant_size_v<Messages>) {
    return std::nullopt;
  } else {
    using Message = std::variant_alternative_t<kIndex, Messages>;
    if (count == 0) return std::nullopt;
    if (bytes[0] != Message::kKind) return decode<Messages, kIndex + 1>(bytes, count);
    Message message;
    Reader reader(bytes + 1, count - 1);
    bool good = true;
    message.fields([&](auto&... field) { good = (reader.get(field) && ...); });
    if (!good || !reader.done()) return std::nullopt;
    if constexpr (requires { message.in_range(); })
      if (!message.in_range()) return std::nullopt;
    return message;
  }
}

}  // namespace kibori::studio
