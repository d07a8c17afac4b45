/* Loses datagrams on their way out: every one with the probability in the variable PACKET_LOSS.
   To be preloaded (LD_PRELOAD) into a process. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <netinet/in.h>
#include <stdlib.h>
#include <sys/random.h>
#include <sys/socket.h>

static int lost(const struct sockaddr *to)
{
    static double share = -1;
    unsigned draw = 0;
    if (share < 0)
        share = getenv("PACKET_LOSS") ? atof(getenv("PACKET_LOSS")) : 0;
    return to && to->sa_family == AF_INET && getrandom(&draw, sizeof draw, 0) == sizeof draw &&
           draw < share * 4294967296.0;
}

ssize_t sendto(int socket, const void *data, size_t size, int flags, const struct sockaddr *to,
               socklen_t length)
{
    ssize_t (*send)(int, const void *, size_t, int, const struct sockaddr *, socklen_t) =
        dlsym(RTLD_NEXT, "sendto");
    return lost(to) ? (ssize_t)size : send(socket, data, size, flags, to, length);
}

ssize_t sendmsg(int socket, const struct msghdr *message, int flags)
{
    ssize_t (*send)(int, const struct msghdr *, int) = dlsym(RTLD_NEXT, "sendmsg");
    ssize_t size = 0;
    if (!lost(message->msg_name))
        return send(socket, message, flags);
    for (size_t part = 0; part < message->msg_iovlen; part++)
        size += message->msg_iov[part].iov_len;
    return size;
}
