#pragma once

#include <httplib.h>

#include <memory>
#include <span>

/// What handlers can ask and say about the connection of the request that they answer.
namespace rivage::server {

/// Whether the client has gone. One that has only ended its sending counts as gone too: the two
/// cannot be told apart before an answer is sent.
[[nodiscard]] bool clientLeft(const httplib::Request& request);

/// Whether the body was given up because it came too slowly.
[[nodiscard]] bool bodyTimedOut(const httplib::Request& request);

/// Lends the bytes of an answer: what a slow client has not taken yet is sent from where it lies,
/// without a thread and without a copy. For bytes that the answer's content provider writes.
/// @param owner  keeps `bytes` alive; nobody changes them
void lendBytes(httplib::Response& response, std::shared_ptr<const void> owner,
               std::span<const std::byte> bytes);

}  // namespace rivage::server
