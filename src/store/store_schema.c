/*
 * Defines the tables of a store, and checks that a file has exactly these. So a view, trigger or index in an untrusted file is
 * never run.
 *
 * Older stores are read, too. A reader sees empty tables in place of those that they lack. A writer makes the store one of this
 * version before anything else.
 *
 *   3: no table `dug`; its `shear` has another meaning, a length that only grew, and counts as none.
 *   4: no history; who made the last commit, and when, is not known. No overlays that show the deformation of their parent.
 *
 *   6: no tables for loose layers.
 *   7: no tables for marks that fade.
 *   8: no table for imagery. Only an import of imagery raises a store to 9 (store_imagery_make.c). Nothing else does.
 *
 * A store gets version 6, with two more tables, when it first keeps what an overlay depends on (store_pinned.c).
 */
#include "store/internal.h"

#include <stdio.h>
#include <string.h>

struct object {
	const char *name, *sql;
};

/* The table of a plane other than the offset. */
#define PLANE_TABLE(name)                                                                          \
	"CREATE TABLE " name "(key INTEGER PRIMARY KEY, low REAL, high REAL, "                     \
	"codec INTEGER NOT NULL, revision INTEGER NOT NULL, hash INTEGER NOT NULL, blob BLOB NOT NULL)"

/* The tables sorted by name, as store_schema_check() reads them. FORMAT.md explains them. */
static const struct object objects[] = {
	{"base",
	 "CREATE TABLE base(key INTEGER PRIMARY KEY, low REAL, high REAL, error REAL NOT NULL, "
	 "codec INTEGER NOT NULL, revision INTEGER NOT NULL, hash INTEGER NOT NULL, blob BLOB NOT NULL)"},
	{"density", PLANE_TABLE("density")},
	{"dirt", PLANE_TABLE("dirt")},
	{"dug", PLANE_TABLE("dug")},
	{"floor", PLANE_TABLE("floor")},
	{"grown", PLANE_TABLE("grown")},
	{"healed", PLANE_TABLE("healed")},
	{"heaped", PLANE_TABLE("heaped")},
	{"history",
	 "CREATE TABLE history(plane INTEGER NOT NULL, key INTEGER NOT NULL, revision INTEGER NOT NULL, form INTEGER NOT NULL, "
	 "codec INTEGER NOT NULL, hash INTEGER NOT NULL, blob BLOB NOT NULL, PRIMARY KEY(plane, key, revision)) WITHOUT ROWID"},
	{"imagery", "CREATE TABLE imagery(key INTEGER PRIMARY KEY, codec INTEGER NOT NULL, hash INTEGER NOT NULL, blob BLOB NOT NULL)"},
	{"loose", PLANE_TABLE("loose")},
	{"meta", "CREATE TABLE meta(key TEXT PRIMARY KEY, value) WITHOUT ROWID"},
	{"offset",
	 "CREATE TABLE \"offset\"(key INTEGER PRIMARY KEY, low REAL, high REAL, below INTEGER NOT NULL, "
	 "above INTEGER NOT NULL, codec INTEGER NOT NULL, revision INTEGER NOT NULL, "
	 "hash INTEGER NOT NULL, blob BLOB NOT NULL)"},
	{"pinned",
	 "CREATE TABLE pinned(revision INTEGER PRIMARY KEY, hash INTEGER NOT NULL, scene_hash TEXT, step INTEGER, time REAL, state TEXT, "
	 "made INTEGER, who TEXT, what TEXT, working INTEGER, compacted INTEGER NOT NULL, relief TEXT)"},
	{"pressed", PLANE_TABLE("pressed")},
	{"replaced",
	 "CREATE TABLE replaced(plane INTEGER NOT NULL, key INTEGER NOT NULL, pinned INTEGER NOT NULL, low REAL, high REAL, below INTEGER, "
	 "above INTEGER, codec INTEGER, revision INTEGER, hash INTEGER, blob BLOB, PRIMARY KEY(plane, key, pinned)) WITHOUT ROWID"},
	{"revision",
	 "CREATE TABLE revision(revision INTEGER PRIMARY KEY, scene_hash TEXT NOT NULL, step INTEGER NOT NULL, time REAL NOT NULL, "
	 "state TEXT NOT NULL, made INTEGER NOT NULL, who TEXT NOT NULL, what TEXT NOT NULL, working INTEGER, compacted INTEGER NOT NULL)"},
	{"risen", PLANE_TABLE("risen")},
	{"run",
	 "CREATE TABLE run(id INTEGER PRIMARY KEY CHECK (id = 1), epoch INTEGER NOT NULL, "
	 "scene_hash TEXT NOT NULL, step INTEGER NOT NULL, time REAL NOT NULL, state TEXT NOT NULL, "
	 "made INTEGER NOT NULL, who TEXT NOT NULL, what TEXT NOT NULL)"},
	{"settled", PLANE_TABLE("settled")},
	{"shear", PLANE_TABLE("shear")},
	{"slope", PLANE_TABLE("slope")},
	{"snapshot",
	 "CREATE TABLE snapshot(name TEXT PRIMARY KEY, revision INTEGER NOT NULL, made INTEGER NOT NULL, who TEXT NOT NULL) WITHOUT ROWID"},
};
#define OBJECTS (sizeof objects / sizeof *objects)

/* The record of a run in versions 3 and 4. */
static const struct object older_run = {
	"run",
	"CREATE TABLE run(id INTEGER PRIMARY KEY CHECK (id = 1), epoch INTEGER NOT NULL, "
	"scene_hash TEXT NOT NULL, step INTEGER NOT NULL, time REAL NOT NULL, state TEXT NOT NULL)",
};

/* Returns a table as a store of this version has it; NULL: it has no such table. */
static const struct object *object_of(size_t index, int version)
{
	static const char *const since_history[] = {"history", "revision", "snapshot"}, *const since_loose[] = {"density", "floor", "loose", "settled", "slope"},
				 *const since_marks[] = {"grown", "healed", "risen"};
	const char *name = objects[index].name;
	if (strcmp(name, "dug") == 0 && version < STORE_VERSION_SHEAR)
		return NULL;
	if (strcmp(name, "imagery") == 0 && version < STORE_VERSION_IMAGERY)
		return NULL;
	if ((strcmp(name, "pinned") == 0 || strcmp(name, "replaced") == 0) && version < STORE_VERSION_PINS)
		return NULL;
	for (size_t i = 0; i < sizeof since_history / sizeof *since_history; i++)
		if (strcmp(name, since_history[i]) == 0 && version < STORE_VERSION_HISTORY)
			return NULL;
	for (size_t i = 0; i < sizeof since_loose / sizeof *since_loose; i++)
		if (strcmp(name, since_loose[i]) == 0 && version < STORE_VERSION_LOOSE)
			return NULL;
	for (size_t i = 0; i < sizeof since_marks / sizeof *since_marks; i++)
		if (strcmp(name, since_marks[i]) == 0 && version < STORE_VERSION_MARKS)
			return NULL;
	return strcmp(name, "run") == 0 && version < STORE_VERSION_HISTORY ? &older_run : &objects[index];
}

static const char *sql_of(const char *name)
{
	size_t index = 0;
	while (strcmp(objects[index].name, name) != 0)
		index++;
	return objects[index].sql;
}

enum status store_schema_create(sqlite3 *db, const char *path)
{
	char header[128];
	snprintf(header, sizeof header, "PRAGMA application_id=%d; PRAGMA user_version=%d",
		 STORE_APPLICATION_ID, STORE_VERSION);
	TRY(store_sql_exec(db, path, "making the store", header));
	for (size_t i = 0; i < OBJECTS; i++)
		if (object_of(i, STORE_VERSION) != NULL)
			TRY(store_sql_exec(db, path, "making the store", objects[i].sql));
	return STATUS_OK;
}

static bool object_is(sqlite3_stmt *statement, const struct object *object)
{
	const char *type = (const char *)sqlite3_column_text(statement, 0);
	const char *name = (const char *)sqlite3_column_text(statement, 1);
	const char *sql = (const char *)sqlite3_column_text(statement, 2);
	return type != NULL && name != NULL && sql != NULL && strcmp(type, "table") == 0 &&
	       strcmp(name, object->name) == 0 && strcmp(sql, object->sql) == 0;
}

static enum status check_objects(sqlite3 *db, const char *path, int version)
{
	sqlite3_stmt *statement = NULL;
	/* meta's own index is a WITHOUT ROWID table's: it has no sql and no row here. */
	TRY(store_sql_prepare(db, path, &statement, "SELECT type, name, sql FROM sqlite_schema ORDER BY name"));
	enum status status = STATUS_OK;
	size_t seen = 0;
	bool same = true;
	int code;
	while ((code = sqlite3_step(statement)) == SQLITE_ROW && same) {
		while (seen < OBJECTS && object_of(seen, version) == NULL)
			seen++;
		same = seen < OBJECTS && object_is(statement, object_of(seen, version));
		seen++;
	}
	while (seen < OBJECTS && object_of(seen, version) == NULL)
		seen++;
	if (same && code != SQLITE_DONE)
		status = store_sql_fail(db, code, path, "reading its schema");
	else if (!same || seen != OBJECTS)
		status = fail_with(STATUS_INPUT, "%s: its tables are not those of a Furrow store of version %d; "
				   "import it again", path, version);
	sqlite3_finalize(statement);
	return status;
}

enum status store_schema_check(sqlite3 *db, const char *path, int *out)
{
	int64_t id, version;
	TRY(store_sql_integer(db, path, "PRAGMA application_id", &id));
	TRY(store_sql_integer(db, path, "PRAGMA user_version", &version));
	if (id != STORE_APPLICATION_ID)
		return fail_with(STATUS_INPUT, "%s: not a Furrow store (application id %llx); make one with "
				 "furrow import", path, (unsigned long long)id & 0xffffffffu);
	if (version < STORE_VERSION_OLDEST || version > STORE_VERSION_IMAGERY)
		return fail_with(STATUS_INPUT, "%s: a store of version %lld, this program knows versions %d to %d; use "
				 "the furrow that made it, or import it again", path, (long long)version, STORE_VERSION_OLDEST, STORE_VERSION_IMAGERY);
	*out = (int)version;
	return check_objects(db, path, *out);
}

enum status store_schema_hide(sqlite3 *db, const char *path, int version)
{
	/* SQLite reads a name without a schema as the temporary table, if there is one. */
	TRY(store_sql_exec(db, path, "opening it", "PRAGMA temp_store=MEMORY"));
	if (version < STORE_VERSION_SHEAR)
		TRY(store_sql_exec(db, path, "opening it", "CREATE TEMP TABLE shear AS SELECT * FROM main.shear LIMIT 0; "
				   "CREATE TEMP TABLE dug AS SELECT * FROM main.shear LIMIT 0"));
	TRY(store_sql_exec(db, path, "opening it", "CREATE TEMP TABLE healed AS SELECT * FROM main.heaped LIMIT 0; "
			   "CREATE TEMP TABLE risen AS SELECT * FROM main.heaped LIMIT 0; CREATE TEMP TABLE grown AS SELECT * FROM main.heaped LIMIT 0"));
	if (version < STORE_VERSION_LOOSE)
		TRY(store_sql_exec(db, path, "opening it", "CREATE TEMP TABLE settled AS SELECT * FROM main.heaped LIMIT 0; "
			   "CREATE TEMP TABLE loose AS SELECT * FROM main.heaped LIMIT 0; CREATE TEMP TABLE floor AS SELECT * FROM main.heaped LIMIT 0; "
			   "CREATE TEMP TABLE density AS SELECT * FROM main.heaped LIMIT 0; CREATE TEMP TABLE slope AS SELECT * FROM main.heaped LIMIT 0"));
	if (version >= STORE_VERSION_HISTORY)
		return STATUS_OK;
	return store_sql_exec(db, path, "opening it", "CREATE TEMP TABLE run AS SELECT *, 0 AS made, '' AS who, '' AS what FROM main.run; "
			      "CREATE TEMP TABLE history(plane, key, revision, form, codec, hash, blob); "
			      "CREATE TEMP TABLE revision(revision, scene_hash, step, time, state, made, who, what, working, compacted); "
			      "CREATE TEMP TABLE snapshot(name, revision, made, who)");
}

/* Gives the run's record its new columns. Who made it, and when, is not known. */
static enum status raise_run(sqlite3 *db, const char *path)
{
	static const char doing[] = "making it a store of this version";
	TRY(store_sql_exec(db, path, doing, "PRAGMA temp_store=MEMORY; CREATE TEMP TABLE older AS SELECT * FROM main.run; DROP TABLE main.run"));
	TRY(store_sql_exec(db, path, doing, sql_of("run")));
	return store_sql_exec(db, path, doing, "INSERT INTO main.run SELECT *, 0, '', '' FROM temp.older; DROP TABLE temp.older");
}

enum status store_schema_raise(sqlite3 *db, const char *path, int version)
{
	static const char doing[] = "making it a store of this version";
	char raise[96];
	enum status status;
	snprintf(raise, sizeof raise, "PRAGMA user_version=%d; COMMIT", STORE_VERSION);
	TRY_OR(failed, store_sql_begin(db, path, doing));
	for (size_t i = 0; i < OBJECTS; i++)
		if (object_of(i, version) == NULL && object_of(i, STORE_VERSION) != NULL)
			TRY_OR(failed, store_sql_exec(db, path, doing, objects[i].sql));
	if (version < STORE_VERSION_SHEAR)
		TRY_OR(failed, store_sql_exec(db, path, doing, "DELETE FROM shear"));
	if (version < STORE_VERSION_HISTORY)
		TRY_OR(failed, raise_run(db, path));
	TRY_OR(failed, store_sql_exec(db, path, doing, raise));
	return STATUS_OK;
failed:
	store_sql_undo(db);
	return status;
}

enum status store_schema_add_imagery(struct store *store)
{
	char raise[64];
	if (store->version >= STORE_VERSION_IMAGERY)
		return STATUS_OK;
	TRY(store_sql_exec(store->db, store->path, "making room for imagery", sql_of("imagery")));
	snprintf(raise, sizeof raise, "PRAGMA user_version=%d", STORE_VERSION_IMAGERY);
	return store_sql_exec(store->db, store->path, "making room for imagery", raise);
}

enum status store_schema_drop_imagery(struct store *store)
{
	char lower[64];
	snprintf(lower, sizeof lower, "DROP TABLE imagery; PRAGMA user_version=%d", STORE_VERSION);
	return store_sql_exec(store->db, store->path, "removing its imagery", lower);
}
