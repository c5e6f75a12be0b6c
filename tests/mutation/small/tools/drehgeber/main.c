/* SPDX-License-Identifier: MIT */
int lx_command(int n);

int main(void)
{
    return lx_command(4);
}
