-- Logs of sessions and runs, robots, and the audit log. The owner has the right to add lines until the lease expires; the
-- epoch counts the owners, and each addition names it.
CREATE TABLE longstep_log (
    kind text NOT NULL CHECK (kind IN ('session', 'run', 'robot', 'audit')),
    id text NOT NULL,
    length bigint NOT NULL DEFAULT 0,
    changed_at timestamptz NOT NULL DEFAULT clock_timestamp(),
    owner text,
    epoch bigint NOT NULL DEFAULT 0,
    expires timestamptz NOT NULL DEFAULT clock_timestamp(),
    PRIMARY KEY (kind, id)
);

CREATE INDEX longstep_log_changed ON longstep_log (kind, changed_at DESC);
CREATE INDEX longstep_log_owned ON longstep_log (kind) WHERE owner IS NOT NULL;

INSERT INTO longstep_log (kind, id) VALUES ('audit', '');

-- One addition to a log: whole lines, at their place in bytes, by the owner with this epoch. Two additions cannot have one
-- place.
CREATE TABLE longstep_line (
    kind text NOT NULL,
    id text NOT NULL,
    place bigint NOT NULL,
    epoch bigint NOT NULL,
    text text NOT NULL,
    PRIMARY KEY (kind, id, place),
    FOREIGN KEY (kind, id) REFERENCES longstep_log (kind, id)
);

-- Data that is written once.
CREATE TABLE longstep_record (
    kind text NOT NULL,
    id text NOT NULL,
    value text NOT NULL,
    written_at timestamptz NOT NULL DEFAULT clock_timestamp(),
    PRIMARY KEY (kind, id)
);
