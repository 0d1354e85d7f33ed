# exid in a container: docker build -t exid . && docker run --rm -v "$PWD:/work" exid fit problem.toml
FROM rust:1.89-slim-bookworm AS build
WORKDIR /build
COPY . .
RUN cargo build --release --locked --bin exid && strip --strip-debug target/release/exid

FROM debian:bookworm-slim
COPY --from=build /build/target/release/exid /usr/local/bin/exid
COPY --from=build /build/LICENSE-MIT /build/LICENSE-APACHE /usr/local/share/doc/exid/
RUN useradd --create-home --uid 1000 exid
USER 1000
WORKDIR /work
ENTRYPOINT ["/usr/local/bin/exid"]
