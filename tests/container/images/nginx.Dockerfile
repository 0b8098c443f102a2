# nginx with the configuration of docker/nginx.conf, and a certificate for the name "proxy".
ARG BASE=debian:bookworm-slim
FROM ${BASE}
RUN apt-get update && \
    DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends nginx openssl && \
    rm -rf /var/lib/apt/lists/*
RUN mkdir /etc/nginx/tls && \
    openssl req -x509 -newkey rsa:2048 -nodes -days 3650 -subj /CN=proxy -addext subjectAltName=DNS:proxy \
        -keyout /etc/nginx/tls/key.pem -out /etc/nginx/tls/cert.pem
COPY docker/nginx.conf /etc/nginx/nginx.conf
CMD ["nginx", "-g", "daemon off;"]
