/*
 * What SQLite executed, by table: it tells each connection's own thread of every statement that begins.
 *
 * Every statement here is of one table, named first after FROM or INTO. What begins otherwise (transactions,
 * pragmas) is of none.
 */
#include "store/internal.h"

#include <string.h>

static const char *const names[STORE_TABLES] = {
	[STORE_BASE_TABLE] = "base",       [STORE_OFFSET_TABLE] = "offset", [STORE_DIRT_TABLE] = "dirt",
	[STORE_HEAPED_TABLE] = "heaped",   [STORE_PRESSED_TABLE] = "pressed", [STORE_SHEAR_TABLE] = "shear",
	[STORE_META_TABLE] = "meta",       [STORE_RUN_TABLE] = "run",       [STORE_NO_TABLE] = "other",
};

const char *store_table_name(enum store_table table)
{
	return names[table];
}

static enum store_table table_of(const char *sql, const char *word)
{
	const char *at = strstr(sql, word);
	if (at == NULL)
		return STORE_NO_TABLE;
	at += strlen(word);
	at += *at == '"';
	for (int table = 0; table < STORE_NO_TABLE; table++) {
		size_t length = strlen(names[table]);
		/* No name begins with another. */
		if (strncmp(at, names[table], length) == 0)
			return (enum store_table)table;
	}
	return STORE_NO_TABLE;
}

static int began(unsigned what, void *user, void *statement, void *text)
{
	struct statements *statements = user;
	const char *sql = text;
	bool reads = strncmp(sql, "SELECT", 6) == 0;
	enum store_table table = table_of(sql, strncmp(sql, "INSERT", 6) == 0 ? " INTO " : " FROM ");
	atomic_uint_fast64_t *count = reads ? &statements->read[table] : &statements->written[table];
	atomic_fetch_add_explicit(count, 1, memory_order_relaxed);
	return 0;
}

void statements_count(struct statements *statements, sqlite3 *db)
{
	sqlite3_trace_v2(db, SQLITE_TRACE_STMT, began, statements);
}

void store_statements(const struct store *store, struct store_statements *out)
{
	*out = (struct store_statements){{0}, {0}};
	for (; store != NULL; store = store->under)
		for (int table = 0; table < STORE_TABLES; table++) {
			out->read[table] += atomic_load_explicit(&store->statements.read[table], memory_order_relaxed);
			out->written[table] += atomic_load_explicit(&store->statements.written[table], memory_order_relaxed);
		}
}
