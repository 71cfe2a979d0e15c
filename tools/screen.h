/* Output of commands, safe for a terminal whatever a file put into its text. */
#ifndef FURROW_TOOLS_SCREEN_H
#define FURROW_TOOLS_SCREEN_H

/* From here on stdout shows no control characters but new lines and tabs. Called once. */
void screen_begin(void);
/* Prints a text of a file that is to be one line: new lines and tabs become spaces. */
void screen_put(const char *text);

#endif
