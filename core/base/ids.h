#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

namespace rivage::core {

enum class PointelId : std::uint32_t {};
enum class SurfelId : std::uint32_t {};
enum class InterfaceId : std::uint32_t {};
enum class MaterialId : std::uint16_t {};  ///< 0 is empty
enum class Label : std::uint16_t {};       ///< 0 is the background

template <typename Id>
[[nodiscard]] constexpr std::underlying_type_t<Id> index(Id id) {
    return static_cast<std::underlying_type_t<Id>>(id);
}

/// Stands for "no such cell" in tables of ids.
template <typename Id>
inline constexpr Id kNone = static_cast<Id>(~std::underlying_type_t<Id>{0});

/// A vector that is indexed by one kind of id, so that a wrong id does not compile.
template <typename Id, typename T>
class IdVector {
public:
    IdVector() = default;
    /// Numbers start at 0; vectors of Eigen start with any value.
    explicit IdVector(std::size_t size) : items_(size) {}
    IdVector(std::size_t size, const T& value) : items_(size, value) {}

    [[nodiscard]] T& operator[](Id id) {
        assert(index(id) < items_.size());
        return items_[index(id)];
    }
    [[nodiscard]] const T& operator[](Id id) const {
        assert(index(id) < items_.size());
        return items_[index(id)];
    }
    [[nodiscard]] std::size_t size() const { return items_.size(); }
    [[nodiscard]] bool empty() const { return items_.empty(); }
    void resize(std::size_t size) { items_.resize(size); }
    void resize(std::size_t size, const T& value) { items_.resize(size, value); }
    Id push_back(T value) {
        items_.push_back(std::move(value));
        return static_cast<Id>(items_.size() - 1);
    }
    [[nodiscard]] auto begin() { return items_.begin(); }
    [[nodiscard]] auto end() { return items_.end(); }
    [[nodiscard]] auto begin() const { return items_.begin(); }
    [[nodiscard]] auto end() const { return items_.end(); }
    [[nodiscard]] std::vector<T>& raw() { return items_; }
    [[nodiscard]] const std::vector<T>& raw() const { return items_; }
    bool operator==(const IdVector&) const = default;

private:
    std::vector<T> items_;
};

}  // namespace rivage::core
