/* Watches and loses datagrams on their way out. To be preloaded (LD_PRELOAD) into a process.

   PACKET_LOSS      the probability with which each is lost (default: 0)
   PACKETS_LEAVING  a file that gets a line for each that would leave the machine (default: none) */
#define _GNU_SOURCE
#include <arpa/inet.h>
#include <dlfcn.h>
#include <fcntl.h>
#include <ifaddrs.h>
#include <netinet/in.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <unistd.h>

static int lost(const struct sockaddr *to)
{
    static double share = -1;
    unsigned draw = 0;
    if (share < 0)
        share = getenv("PACKET_LOSS") ? atof(getenv("PACKET_LOSS")) : 0;
    return to && to->sa_family == AF_INET && getrandom(&draw, sizeof draw, 0) == sizeof draw &&
           draw < share * 4294967296.0;
}

static int is_loopback(struct in_addr address) { return ntohl(address.s_addr) >> 24 == 127; }

static int is_ours(struct in_addr address)
{
    struct ifaddrs *all = NULL;
    int found = 0;
    if (getifaddrs(&all))
        return 0;
    for (struct ifaddrs *one = all; one; one = one->ifa_next)
        if (one->ifa_addr && one->ifa_addr->sa_family == AF_INET)
            found |= ((struct sockaddr_in *)one->ifa_addr)->sin_addr.s_addr == address.s_addr;
    freeifaddrs(all);
    return found;
}

static int leaves(int socket, const struct sockaddr *to)
{
    if (to->sa_family == AF_INET6)
        return !IN6_IS_ADDR_LOOPBACK(&((const struct sockaddr_in6 *)to)->sin6_addr);
    if (to->sa_family != AF_INET)
        return 0;
    struct in_addr address = ((const struct sockaddr_in *)to)->sin_addr, card = {0};
    socklen_t size = sizeof card;
    if (!IN_MULTICAST(ntohl(address.s_addr)))
        return !is_loopback(address) && !is_ours(address);
    return getsockopt(socket, IPPROTO_IP, IP_MULTICAST_IF, &card, &size) || !is_loopback(card);
}

static void watch(int socket, const struct sockaddr *to)
{
    const char *path = getenv("PACKETS_LEAVING");
    if (!path || !to || !leaves(socket, to))
        return;
    char text[INET6_ADDRSTRLEN + 1] = "IPv6";
    if (to->sa_family == AF_INET)
        inet_ntop(AF_INET, &((const struct sockaddr_in *)to)->sin_addr, text, sizeof text);
    int file = open(path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
    dprintf(file, "%s\n", text);
    close(file);
}

ssize_t sendto(int socket, const void *data, size_t size, int flags, const struct sockaddr *to,
               socklen_t length)
{
    ssize_t (*send)(int, const void *, size_t, int, const struct sockaddr *, socklen_t) =
        dlsym(RTLD_NEXT, "sendto");
    watch(socket, to);
    return lost(to) ? (ssize_t)size : send(socket, data, size, flags, to, length);
}

ssize_t sendmsg(int socket, const struct msghdr *message, int flags)
{
    ssize_t (*send)(int, const struct msghdr *, int) = dlsym(RTLD_NEXT, "sendmsg");
    ssize_t size = 0;
    watch(socket, message->msg_name);
    if (!lost(message->msg_name))
        return send(socket, message, flags);
    for (size_t part = 0; part < message->msg_iovlen; part++)
        size += message->msg_iov[part].iov_len;
    return size;
}
