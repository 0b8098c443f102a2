#pragma once

#include "core/base/result.h"
#include "server/net/address.h"
#include "server/net/fd.h"

namespace rivage::server {

/// A socket that takes connections. Several processes may share it: whoever owns a copy may stop
/// accepting at any time, the others go on, and what nobody has accepted waits in the kernel.
struct Listener {
    Fd fd;
    Address address;  ///< with the port that was bound

    /// Removes the file of a Unix socket, for the process that ends the service. Destruction only
    /// closes the descriptor, because another process may still listen.
    void remove() const { removeSocketFile(address); }
};

/// Binds and listens; the socket is non-blocking and not inherited by programs that are started.
/// @errors invalidOption if there is no such address; busy if another server listens there
core::Result<Listener> listenOn(const Address& address);

/// A second owner of the same socket. @errors internal if there is no descriptor left
core::Result<Listener> share(const Listener& listener);

}  // namespace rivage::server
