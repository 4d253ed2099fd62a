# The study in a container: docker build -t microimpact . ; docker run -v "$PWD/results:/study/results" microimpact
# It runs as the user 1000, who must be allowed to write into the results.
FROM debian:bookworm-slim@sha256:96e378d7e6531ac9a15ad505478fcc2e69f371b10f5cdf87857c4b8188404716
RUN apt-get update \
    && apt-get install -y --no-install-recommends ca-certificates git make python3-venv \
    && rm -rf /var/lib/apt/lists/* \
    && useradd --uid 1000 --create-home study \
    && install -d -o study /study
USER study
WORKDIR /study
COPY --chown=study . .
RUN make .venv/.compiled
CMD ["make", "reproduce"]
