# The study in a container: docker build -t microimpact . ; docker run -v "$PWD/results:/study/results" microimpact
FROM debian:bookworm-slim
RUN apt-get update \
    && apt-get install -y --no-install-recommends ca-certificates git make python3-venv \
    && rm -rf /var/lib/apt/lists/*
WORKDIR /study
COPY . .
RUN make .venv/.compiled
CMD ["make", "reproduce"]
